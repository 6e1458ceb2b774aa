"""The simulator: the walker bouncing on the plate, with the effects that its scene calls for."""
