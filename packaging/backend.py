"""Build backend: hatchling's, which for an editable install is given what compiles the kernels.

`hatch_build.py` compiles them then, so that the first simulation after `pip install -e .` starts at
once, as it does from a wheel that has its kernels along.
"""

import re
import tomllib
from pathlib import Path
from typing import Any

from hatchling import build
from hatchling.build import (
    build_editable,
    build_sdist,
    build_wheel,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
)

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
]

COMPILES = {
    *("contourpy", "lib3mf", "manifold3d", "matplotlib", "numba", "numpy", "pillow", "platformdirs", "pydantic"),
    *("rich", "scipy", "shapely", "tomli-w", "typer"),
}
"""Those of the project's dependencies that the commands of `hatch_build.py` import."""


def get_requires_for_build_editable(config_settings: dict[str, Any] | None = None) -> list[str]:
    """List the requirements of hatchling, and those of its commands in the versions that the project requires."""
    project = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))["project"]
    needed = [line for line in project["dependencies"] if re.match(r"[\w-]+", line)[0] in COMPILES]
    return [*build.get_requires_for_build_editable(config_settings), *needed]
