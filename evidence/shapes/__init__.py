"""Sixty shapes as people bring them, drawings, meshes, names: built, checked and run without a hand on the legs."""
