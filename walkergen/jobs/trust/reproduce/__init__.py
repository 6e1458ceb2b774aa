"""The job `reproduce`: the paper beside our theory and simulations."""
