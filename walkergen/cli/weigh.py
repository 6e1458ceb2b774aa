"""The command `weigh`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from walkergen.cli import options as opt
from walkergen.cli import show

if TYPE_CHECKING:
    from walkergen.jobs.weigh.make import Weighed
    from walkergen.walker.mass import Array


def weigh(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="Mesh: STL, OBJ, PLY, OFF, 3MF or GLB.")
    ],
    density: Annotated[
        float, typer.Option("--density", metavar="G/CM3", help="Density of the material, g/cm3.")
    ] = 1.24,
    scale: Annotated[
        float, typer.Option("--scale", metavar="MM", help="Length of the file's unit, mm.")
    ] = 1.0,
    json: opt.AsJson = False,
) -> None:
    """Weigh a mesh: volume, mass, centre of mass, inertia tensor, principal moments and axes."""
    from walkergen.jobs.weigh import make

    found = make.weigh(file, density, scale)
    if json:
        show.as_json({
            "density_g_cm3": density,
            "scale_mm": scale,
            "sha256": found.sha256,
            "parts": [_plain(part) for part in found.parts],
            "total": _plain(found.total),
        })  # fmt: skip
        return
    print(f"{file.name}: {density:g} g/cm3, 1 unit = {scale:g} mm, axes as in the file")
    for part in found.parts:
        _show(part)
    if len(found.parts) > 1:
        _show(found.total)


def _plain(part: "Weighed") -> dict[str, Any]:
    """Fields of an object as JSON has them: arrays as lists."""
    return {key: getattr(value, "tolist", lambda value=value: value)()
            for key, value in part._asdict().items()}  # fmt: skip


def _show(part: "Weighed") -> None:
    print(f"\n{part.name}, {part.triangles} triangles")
    print(f"  volume            {part.volume_mm3:14.6g} mm3")
    print(f"  mass              {part.mass_g:14.6g} g")
    for label, row, unit in (
        ("centre of mass", part.centre_mm, "mm"),
        ("inertia tensor", part.tensor_g_mm2[0], "g mm2, about the centre"),
        ("", part.tensor_g_mm2[1], ""),
        ("", part.tensor_g_mm2[2], ""),
        ("principal moments", part.moments_g_mm2, "g mm2"),
        ("principal axes", part.axes[0], "of the first moment"),
        ("", part.axes[1], "of the second"),
        ("", part.axes[2], "of the third"),
    ):
        told = "".join(f"{value:14.6g}" for value in _without_rounding(row))
        print(f"  {label:18s}{told}  {unit}".rstrip())


def _without_rounding(row: "Array") -> "Array":
    """Values of a row, those that are nothing but rounding as zeros."""
    import numpy as np

    return np.where(np.abs(row) < 1e-12 * np.abs(row).max(), 0.0, row)
