"""The wing of jobs that learn from prints, balances, films and bench tests."""
