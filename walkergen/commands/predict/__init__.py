"""The job `predict`: speeds of walkers in a scene, with their bounds. It writes no file."""
