"""The command `reproduce`."""

from pathlib import Path
from typing import Annotated

import typer

from walkergen.cli import loading, show, variants
from walkergen.cli import options as opt
from walkergen.errors import InputError
from walkergen.files import key_names, words

FITTED = "lane-90hz-fitted"


def reproduce(
    design: opt.DesignName = opt.PAPER,
    scene: opt.SceneName = opt.SCENE,
    scene_fitted: Annotated[
        str, typer.Option("--scene-fitted", metavar="SCENE", help="Scene whose contact fits best.")
    ] = FITTED,
    tilt: opt.Tilt = None,
    gamma: Annotated[str | None, typer.Option("--gamma", metavar="G", help="Drives of figure 5: 1.2,1.8,2.4.")] = None,
    seconds: opt.Seconds = None,
    runs: opt.Runs = None,
    seed: opt.Seed = None,
    keys: opt.Values = None,
    out: opt.Out = None,
    json: opt.AsJson = False,
    quiet: opt.Quiet = False,
) -> None:
    """Compare the paper's figures and mechanisms with ours (takes minutes)."""
    from walkergen.jobs.trust.reproduce import make as side_by_side

    inputs = loading.inputs(keys, "design scene", seconds=seconds, runs=runs, seed=seed)
    inputs.refuse(
        key_names.TILTS + key_names.KINDS,
        "the paper's tilts, or those of --tilt, are compared with both kinds of legs: leave it out",
    )
    own = {"seconds": side_by_side.SECONDS, "runs": side_by_side.RUNS}
    job = side_by_side.Job(
        inputs.design(design),
        inputs.scene(scene, **own),
        inputs.scene(scene_fitted, **own),
        None if tilt is None else variants.parse_tilts(tilt),
        None if gamma is None else parse_gammas(gamma),
    )
    folder = out or Path("out") / "reproduce"
    about_s = side_by_side.expected_s(job)
    with show.progress("reproduce", wanted=not quiet, about_s=about_s) as progress:
        report = side_by_side.make(job, folder, progress)
    show.report(report, json, quiet)


def parse_gammas(text: str) -> list[float]:
    """Parse comma-separated peak accelerations over g. Raises InputError outside 0..50."""
    values = [words.value(word) for word in text.split(",")]
    gammas = [value for value in values if value is not None]
    if len(gammas) < len(values):
        raise InputError(f"--gamma {text[:60]!r}: write numbers with commas: 1.2,1.8,2.4")
    if not all(0.01 <= value <= 50.0 for value in gammas):
        raise InputError(f"--gamma {text[:60]!r}: each must lie in 0.01..50")
    return gammas
