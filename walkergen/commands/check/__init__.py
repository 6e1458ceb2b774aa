"""The job `check`: whether walkers will print as designed. It writes no file."""
