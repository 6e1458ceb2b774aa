"""Jobs that prepare a print: `export`, `check` and `plate`."""
