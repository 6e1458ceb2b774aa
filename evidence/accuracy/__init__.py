"""What accuracy costs in time, measured for the shipped plate: the data that `accuracy` answers from."""
