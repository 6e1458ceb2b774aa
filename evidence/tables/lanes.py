"""Walkers in lanes, on plates with a second harmonic and at the ends of friction: rows not yet in a table.

`lanes.csv` has what the stored table of plates lacks: walls with 0.05 to 3 mm of play (blank: an open
plane), harmonics up to half of the drive, friction 0.02 to 1.2, accelerations from 1 g, and how many of
the runs toppled. 220 of the rows are `held_out`, of 16 runs of 4 s each, for a test of whatever is fitted
to the others, which have 6 runs of 1.5 s. Simulated at commit ef8a41e, in five minutes of 16 cores.
"""

import csv
from collections.abc import Iterator, Mapping
from pathlib import Path

from evidence.tables.cases import Case
from walkergen.scene import Arena, Contact, Drive, Feet, LegModel, Plate, Run, Scene
from walkergen.walker.body import Body
from walkergen.walker.design import Design
from walkergen.walker.limbs import Legs

ROWS = Path(__file__).with_name("lanes.csv")

RUN = Run(seconds=1.5, discard_seconds=0.3, runs=6)

Row = Mapping[str, float | None]


def read() -> Iterator[Row]:
    """Rows by the names of their columns, None where one is blank."""
    with ROWS.open(encoding="utf-8", newline="") as stream:
        for line in csv.DictReader(stream):
            yield {key: float(text) if text else None for key, text in line.items()}


def case(row: Row) -> Case:
    """Walker and scene of a row."""
    number = {key: value or 0.0 for key, value in row.items()}
    body = Body(
        length_mm=number["body_length_mm"], thickness_mm=number["body_thickness_mm"], depth_mm=number["depth_mm"]
    )
    legs = Legs(
        tilt_deg=number["tilt_deg"],
        length_mm=number["length_mm"],
        contact_spacing_mm=number["spacing_mm"],
        flexible_thickness_mm=number["thickness_mm"],
    )
    drive = Drive(
        frequency_hz=number["frequency_hz"],
        gamma=number["gamma"],
        second_harmonic_ratio=number["harmonic_ratio"],
        second_harmonic_phase_deg=number["harmonic_phase_deg"],
    )
    walls = Arena(
        gap_mm=number["depth_mm"] + number["play_mm"],
        wall_friction=number["wall_friction"],
        wall_restitution=number["wall_restitution"] or 0.5,
    )
    run = Run(seconds=4.0, discard_seconds=0.5, runs=16) if row["held_out"] else RUN
    scene = Scene(
        drive=drive,
        contact=Contact(restitution=number["restitution"], friction=number["friction"]),
        plate=Plate(slope_deg=number["slope_deg"], noise_ratio=number["noise_ratio"]),
        arena=Arena(kind="plane") if row["play_mm"] is None else walls,
        legs=LegModel(model="space"),
        feet=Feet(unevenness_um=number["unevenness_um"]),
        run=run,
    )
    return Case(scene, Design(body=body, legs=legs))
