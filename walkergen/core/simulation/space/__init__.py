"""The walker in space, on elastic feet, by time steps (docs/physics.md section 7)."""
