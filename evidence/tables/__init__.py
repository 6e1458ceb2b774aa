"""Job of `make calibrate-models`: simulated speeds from which the theory's own error is read."""
