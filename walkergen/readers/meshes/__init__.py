"""Solids from files of meshes, their faults and repairs."""
