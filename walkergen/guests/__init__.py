"""Guests: crowds, films and tracks, fits, sweeps and movies, which stand on the core and of which it knows nothing."""
