"""Files that people write and read: TOML and CSV in; CSV, Markdown, pictures and folders out."""
