"""The wing of jobs that run walkers in a scene."""
