"""The command `reproduce`: the paper beside our theory and simulations."""
