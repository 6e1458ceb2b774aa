"""The job `simulate`: speed, motion, landings and tracks of a walker's runs in a scene."""
