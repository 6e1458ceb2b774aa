"""Sweeps: a table of a walker's speed and other quantities, over values of any keys of its design and its scene."""
