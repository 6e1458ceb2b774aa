"""Shapes: meshes, outlines and letters, their solids and files; nothing here knows a walker."""
