"""Job of `crowd --card`: what a crowd in a plane has to know of a walker, from runs or films."""
