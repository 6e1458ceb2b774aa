"""Motion of tracked or simulated walkers: arrays in, statistics with their errors out."""
