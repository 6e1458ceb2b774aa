"""The jobs that prepare a print: `export`, `check` and `plate`."""
