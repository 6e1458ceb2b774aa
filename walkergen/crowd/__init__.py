"""Crowds: walkers that meet, in space and in a plane; their statistics, cards and reports."""
