"""Published crowds compared with ours."""
