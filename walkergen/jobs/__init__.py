"""Jobs: what each command makes. No job imports another."""
