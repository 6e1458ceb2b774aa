"""Shapes: meshes, outlines and letters, their solids and files, independent of walkers."""
