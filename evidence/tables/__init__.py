"""Rows that the surrogate learns from, its training, its test on settings that it has not seen; the paper's contact."""
