"""The job `crowd`: many walkers in a dish, and what they do together."""
