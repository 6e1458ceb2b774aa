"""What accuracy costs in time: measured ladders, and the choice of the cheapest setting."""
