"""Preparation of prints: from meshes to printers' files and plates."""
