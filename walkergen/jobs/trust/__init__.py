"""The wing of jobs that say how far walkergen's numbers hold."""
