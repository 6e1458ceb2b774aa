"""Published walkers, predicted over what their authors leave open."""
