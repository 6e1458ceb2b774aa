"""Job of `calibrate`: strips, block and walker to measure, and after."""
