"""The command `movie`: one walker in slow motion, or several side by side."""
