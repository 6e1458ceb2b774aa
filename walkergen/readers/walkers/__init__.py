"""Bodies and legs that are found in drawings and meshes; marks and caps."""
