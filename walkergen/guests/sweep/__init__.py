"""Sweeps: a table of a walker's numbers over any keys of its design and its scene."""
