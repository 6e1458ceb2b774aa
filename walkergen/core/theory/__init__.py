"""The analytical theory: inverse-mass tensors, the frictional impact law, stationary speeds."""
