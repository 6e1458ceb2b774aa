"""The job `check`: whether walkers will print as designed, without any file."""
