"""The command `reproduce`: the paper compared with our theory and simulations."""
