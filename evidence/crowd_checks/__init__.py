"""Whether a walker has in a plane what it has in space: alone, in pairs, in a crowd."""
