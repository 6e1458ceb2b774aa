"""The wing of the job that shows a family in a browser."""
