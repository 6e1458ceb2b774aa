"""The job `movie`: one walker in slow motion, or several side by side."""
