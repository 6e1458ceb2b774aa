"""Outlines from drawings and letters."""
