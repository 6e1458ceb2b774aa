"""Crowds, as the command `crowd` makes them."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from walkergen.api.loading import Ground, Name, Walker, scene_of, walker_of
from walkergen.crowd import in_plane, make, report
from walkergen.crowd import in_space as crowd_space
from walkergen.crowd import members as crowd_members
from walkergen.crowd.cards import card as cards
from walkergen.crowd.cards.card import Card
from walkergen.crowd.members import RATE_HZ, RUNS
from walkergen.crowd.report import CrowdReport
from walkergen.errors import InputError
from walkergen.files.progress import Progress, silent

PAPER, SCENE = "koumakis2016", "plane-90hz"


def crowd(
    design: Walker | Card = PAPER,
    scene: Ground = SCENE,
    *,
    count: int | Mapping[Name, int] | None = None,
    packing: float | None = None,
    arena: str | None = None,
    seconds: float | None = None,
    runs: int = RUNS,
    seed: int | None = None,
    rate_hz: float = RATE_HZ,
    threads: int | None = None,
    out: Name | None = None,
    progress: Progress | None = None,
) -> CrowdReport:
    """Let many walkers run in a dish and meet: order, clusters and packing with their errors.

    `count` is a number of walkers of the design, or numbers by the names or paths of several
    designs, which then stand for `design`: {"polar-disc": 20, "rotator": 10}; or `packing` says how
    many. `arena`: "disc:120", "ring:160,60", "rectangle:200x100" or "periodic:150", mm. What is
    None is the scene's. Every run begins at other places; their scatter gives the errors. A card,
    or paths of cards (.json), makes a crowd in a plane, by LAMMPS. With `out` a folder of tables,
    figures and tracks is written. Raises InputError.
    """
    mixed = isinstance(count, Mapping)
    sources: list[Any] = list(count) if isinstance(count, Mapping) else [design]
    counts = list(count.values()) if isinstance(count, Mapping) else None
    total = sum(counts) if counts is not None else count
    if total is not None:
        assert not isinstance(total, Mapping)
        crowd_members.check(total, f"count={count!r}")
    values = {
        "crowd.count": total,
        "crowd.packing": packing,
        "crowd.arena_mm": arena,
        "run.seconds": seconds,
        "run.runs": runs,
        "run.seed": seed,
    }
    ground = scene_of(scene).variant(**{k: v for k, v in values.items() if v is not None})
    flat = [_is_card(source) for source in sources]
    if mixed and any(flat) and not all(flat):
        raise InputError(f"count={count!r}: give designs, or cards for all")
    shown = progress or silent
    if all(flat):
        known = [own if isinstance(own, Card) else cards.read(Path(own)) for own in sources]
        job = in_plane.asked(ground, known, counts, rate_hz)
    else:
        job = crowd_space.asked(ground, [walker_of(own) for own in sources], counts, rate_hz)
    simulated = make.simulate(job, threads, shown)
    folder = None if out is None else Path(out)
    result = report.of(simulated, folder)
    return result if folder is None else report.write(result, folder, True, shown)


def _is_card(source: Any) -> bool:
    """Whether a walker is known by a card."""
    named = isinstance(source, (str, os.PathLike)) and str(source).lower().endswith(".json")
    return named or isinstance(source, Card)
