"""Front for Python, `import walkergen as wg`: each function calls what its command calls."""
