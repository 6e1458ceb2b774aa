"""Crowds of walkers in space with contacts between bodies: each moves as if alone between contacts."""
