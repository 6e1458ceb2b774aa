"""The wing of jobs that make walkers: their files, plates and designs."""
