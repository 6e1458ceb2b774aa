"""The job `validate`: every prediction against what is known outside walkergen."""
