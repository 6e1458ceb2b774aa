"""Bench, calibration and fits: what measurements say of plate, plastic and walker."""
