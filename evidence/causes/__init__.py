"""What could bring the facts that the model misses, one cause at a time."""
