"""Guests: crowds, films, tracks, fits, sweeps and movies. They use the core; the core does not import them."""
