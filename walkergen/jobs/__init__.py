"""Jobs: what each command makes, in five wings. No job imports another."""
