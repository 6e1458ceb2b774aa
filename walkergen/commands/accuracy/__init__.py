"""The job `accuracy`: what accuracy costs in time, and the cheapest setting for an error."""
