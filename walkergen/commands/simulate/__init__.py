"""The job `simulate`: from a scene to the speed, motion, landings and tracks of its runs."""
