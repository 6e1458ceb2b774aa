"""Front for Python, `import walkergen as wg`: each function calls what its command calls."""

from walkergen.core.walker.design import Design


def _show(design: Design) -> str:
    """Return the HTML by which a notebook shows a walker."""
    from walkergen.api import notebook

    return notebook.html(design)


Design._repr_html_ = _show  # type: ignore[attr-defined]  # notebooks look for this name
