"""Crowds of walkers in space, whose bodies meet: each moves as it does alone between contacts."""
