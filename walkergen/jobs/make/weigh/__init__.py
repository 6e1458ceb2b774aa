"""Job of `weigh`: mass properties of any mesh file."""
