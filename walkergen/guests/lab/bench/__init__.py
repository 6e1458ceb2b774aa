"""Bench tests of a walker, simulated: a drop, an incline, a plucked leg, and their inverses."""
