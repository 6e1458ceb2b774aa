"""The job `selftest`: hard cases with exact outcomes or invariants."""
