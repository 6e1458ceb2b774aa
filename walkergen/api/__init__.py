"""Python interface, `import walkergen as wg`: each function calls the same job as its command."""

from walkergen.core.walker.design import Design


def _show(design: Design) -> str:
    """Return the HTML of a walker for a notebook."""
    from walkergen.api import notebook

    return notebook.html(design)


Design._repr_html_ = _show  # type: ignore[attr-defined]  # notebooks look for this name
