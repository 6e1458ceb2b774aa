"""Points of a design in a scene, wherever they come from and wherever they run."""
