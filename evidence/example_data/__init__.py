"""Example data: what a film, a plate and a card are like, with what the program finds in them."""
