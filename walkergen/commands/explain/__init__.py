"""The job `explain`: the effects that a scene calls for, and what they cost."""
