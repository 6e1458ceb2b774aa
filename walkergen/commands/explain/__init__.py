"""The job `explain`: the physical effects that a scene requires, and their cost in CPU time."""
