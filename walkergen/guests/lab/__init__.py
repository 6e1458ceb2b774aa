"""Bench, calibration and fits: plate, plastic and walker from measurements."""
