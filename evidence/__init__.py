"""What walkergen's numbers rest on: run from a checkout, not installed."""
