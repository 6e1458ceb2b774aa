"""Claims against programs that do a part of what walkergen does; each only where installed."""

import math
import re
import shutil
import subprocess
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from evidence.validate.claim import Claim, Effort, Outside
from evidence.validate.claims_rivals import MISSING_EXTRA, format_version, is_installed
from evidence.validate.ensembles import paper_design
from walkergen.analysis import lag_sums
from walkergen.core.printing import export, print_sheet, slicer
from walkergen.core.printing.printers import Printer
from walkergen.core.scene import Scene
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import simulate
from walkergen.core.simulation.space.state import SHOWN_X, SHOWN_Y, TRAJECTORY_COLUMNS
from walkergen.core.walker import solids
from walkergen.files import templates
from walkergen.points.trajectory import sample_rows

SLICER = Outside(
    "PrusaSlicer, its length of filament, with our settings",
    0.01,
    "one per cent; the settings' infill overlap was chosen for it",
    "The slicer only plans. Weigh the print to know the mass.",
)

LAGS = (1, 10, 50)
"""Lags of the mean square displacement, in samples."""

SAMPLE_INTERVAL_S = 0.01
"""Time between samples of the track, s."""

TIMEOUT_S = 120.0


def squared_displacement(effort: Effort) -> Iterator[Claim]:
    """Claim on the mean square displacement of one simulated track, against trackpy's."""
    outside = Outside(f"trackpy{format_version('trackpy')}, its imsd", 1e-9, "rounding of transforms")
    quantity = "mean square displacement at 35 deg over {:g} s"
    if not (is_installed("trackpy") and is_installed("pandas")):
        for lag in LAGS:
            yield outside.missing(quantity.format(lag * SAMPLE_INTERVAL_S), "mm²", MISSING_EXTRA.format("trackpy"))
        return
    import pandas as pd
    import trackpy

    scene = templates.load("plane-90hz", "scenes", Scene)
    run = scene.run.model_copy(update={"seconds": 2.0, "discard_seconds": 0.5, "runs": 1})
    design = paper_design(35.0)
    plan = prepare(scene.model_copy(update={"run": run}), design, solids.mass_of(design))
    rows = sample_rows(simulate(plan, 0, sample_interval=SAMPLE_INTERVAL_S, sample_size=len(TRAJECTORY_COLUMNS)))
    position = np.ascontiguousarray(rows[:, [1 + SHOWN_X, 1 + SHOWN_Y]])
    total, pairs = lag_sums.sum_squares(position, np.array(LAGS))
    film = pd.DataFrame({"frame": np.arange(len(position)), "particle": 0, "x": position[:, 0], "y": position[:, 1]})
    with warnings.catch_warnings(action="ignore"):  # trackpy calls pandas in ways it deprecates
        theirs = trackpy.imsd(film, mpp=1.0, fps=1.0, max_lagtime=max(LAGS))[0]
    for lag, ours in zip(LAGS, total / pairs, strict=True):
        yield outside.claim(quantity.format(lag * SAMPLE_INTERVAL_S), "mm²", float(ours), float(theirs.loc[lag]))


def plastic_mass(effort: Effort) -> Iterator[Claim]:
    """Claim on the plastic of a printed walker, against what PrusaSlicer would lay down."""
    program = shutil.which("prusa-slicer")
    for tilt, kind in ((10.0, "flexible"), (35.0, "flexible"), (10.0, "braced")):
        quantity = f"plastic of a walker at {tilt:g} deg, {kind}"
        if program is None:
            yield SLICER.missing(quantity, "g", "prusa-slicer is not on the PATH")
            continue
        design = paper_design(tilt, "braced" if kind == "braced" else "flexible").unmarked
        built = solids.build(design)
        printer = templates.load("prusa-mk3s", "printers", Printer)
        weight = print_sheet.expected_masses("walker", design, built, printer)
        mesh = export.stl_bytes(built.walker, "walker")
        volume = filament_volume(program, mesh, slicer.prusaslicer_print(printer))
        if volume is None:
            yield SLICER.missing(quantity, "g", "prusa-slicer ended without G-code")
            continue
        theirs = 1e-3 * design.material.density_g_cm3 * volume
        yield SLICER.claim(quantity, "g", weight.whole_g, theirs)


def filament_volume(program: str, mesh: bytes, settings: bytes) -> float | None:
    """Volume (mm^3) of the filament that PrusaSlicer uses for an STL mesh; None when it fails."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "walker.stl").write_bytes(mesh)
        (folder / "settings.ini").write_bytes(settings)
        options = "--load settings.ini --skirts 0 --brim-width 0 --export-gcode --output walker.gcode walker.stl"
        try:
            subprocess.run([program, *options.split()], cwd=folder, capture_output=True, check=True, timeout=TIMEOUT_S)
            text = (folder / "walker.gcode").read_text(encoding="utf-8", errors="replace")
        except (OSError, subprocess.SubprocessError):
            return None
    used = re.search(r"; filament used \[mm\] = ([0-9.]+)", text)
    return None if used is None else float(used[1]) * math.pi * slicer.FILAMENT_DIAMETER_MM**2 / 4.0


TESTS = (squared_displacement, plastic_mass)
