"""TOML and CSV in; tables, words and whole folders out."""
