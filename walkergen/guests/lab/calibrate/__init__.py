"""Job of `calibrate`: make strips, block and walker to measure, and compute material and contact from readings."""
