"""The walker: its design, its solids, its masses, its marks and its name."""
