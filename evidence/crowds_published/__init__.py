"""Published crowds beside ours."""
