"""Job of `crowd --card`: the parameters of a walker for a crowd in a plane, from runs or films."""
