"""The job `design`: designs that meet a wish, searched, verified and written."""
