"""The simulator: the walker bouncing on the plate, with only the effects that the scene calls for."""
