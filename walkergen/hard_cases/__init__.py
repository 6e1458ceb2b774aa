"""Hard cases: scenes with an exact outcome or an invariant, over every model and method."""
