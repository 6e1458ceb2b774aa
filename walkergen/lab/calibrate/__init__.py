"""Job of `plate --calibration` and `calibrate`: strips, block and walker to measure, and after."""
