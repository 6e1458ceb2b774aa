"""The job `plate`: copies of walkers arranged on print-ready plates."""
