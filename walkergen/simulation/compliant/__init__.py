"""Model B: body and legs as a hinged chain on springs, by time steps."""
