"""Tracking: from a film from above to tracks with headings, and a picture to check."""
