"""The job `analyse`: from tracks to speed, persistence and spread."""
