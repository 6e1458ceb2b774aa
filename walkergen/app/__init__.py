"""The page on which walkers are designed, `walkergen app`, and the server behind it."""
