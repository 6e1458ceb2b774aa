"""Pictures of plates, and sheets of caps."""
