"""Page of the reproduction, as it could be printed in the paper's supplement."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

from walkergen.files.tables import as_markdown
from walkergen.jobs.paper.compare import (
    FRICTIONS,
    RESTITUTIONS,
    Findings,
    Row,
    series_of,
    through_zero,
)
from walkergen.jobs.paper.facts import FACTS, NOT_YET, judge
from walkergen.jobs.paper.sweeps import QUIET, Point, Value
from walkergen.jobs.paper.tables import name, number, to_table
from walkergen.simulation.compliant.model import STEP_US


def to_markdown(found: Findings, rows: Sequence[Row], design: str) -> str:
    """Format the page: what comes out, the table, the statements, the figures."""
    scene = found.assumptions[0].scene
    run, drive, factor = scene.run, scene.drive, scene.prediction.impact_speed_factor
    return f"""# The paper, side by side

Statements of Koumakis, Gnoli, Maggi, Puglisi and Di Leonardo, *Mechanism of self-propulsion in
3D-printed active granular particles* (2016), against walkergen's theory and simulations of its own
printed geometry ({design}) on a plate shaken at {drive.frequency:g} Hz with {drive.peak_gamma:g} g
({drive.peak_speed:.1f} mm/s). Each simulated number: {run.runs} runs of {run.seconds:g} s, after
{run.discard_seconds:g} s discarded; seed {run.seed}; Poisson's law of restitution; compliant legs
in steps of {run.step_us or STEP_US:g} µs.

## What comes out

{_listed(_agreements(rows))}

Beside the table:

{_listed(_notes(found))}

## Table

{as_markdown(to_table(rows, found.assumptions))}

± is twice the standard error over the runs; for landings over the tilts; of the theory twice the
standard deviation that those of restitution, friction and masses give, with impact speed
w = {factor:g} x the plate's peak speed. A number agrees when all of its ± lies within the paper's
margin ("within x": x from the stated value), differs when none of it does, and is undecided in
between. The bias of the time steps is not in ± (`walkergen accuracy` measures it).

## Statements

{_statements()}

{_listed(f"Figure {figure}. {why}" for figure, why in NOT_YET.items())}

## Figures

![Figure 2](figure2.png)

Figure 2. Speed against tilt. Star: the paper's stated peak, with our margins. Theory with
w = {factor:g} x the plate's peak speed; its band is one standard deviation. Bars are two standard
errors.

![Figure 3](figure3.png)

Figure 3. Types of impacts against tilt, with the fitted contact, counted in three ways: every
impact, chatter included; landings, a foot's first impact after {1e3 * QUIET:g} ms without one;
by normal impulse. As in the paper the foot's sliding speed I stays forward, II turns backward
during restitution, III during compression, IV stays backward. From rest (exactly) is the limit of
type III. The table takes the tilts above 0, for an upright walker slides either way.

![Figure 5](figure5.png)

Figure 5. Speed against the plate's peak speed at {found.drives[0].tilt_deg:g} deg and
{drive.frequency:g} Hz, with least-squares lines through zero. The theory is proportional by
construction. Slopes: {_slopes(found)}.
"""


def _listed(lines: Iterator[str] | Sequence[str]) -> str:
    return "\n".join(f"- {line}" for line in lines)


def _statements() -> str:
    return "\n".join(
        f"{place}. Figure {fact.figure}, {fact.where}: “{fact.quote}”. "
        f"Compared: {fact.quantity}, {fact.claim} (margin: {fact.margin})."
        for place, fact in enumerate(FACTS.values(), start=1)
    )


def _agreements(rows: Sequence[Row]) -> Iterator[str]:
    """Lines that list, for each fact, the assumptions under which it comes out."""
    for key, fact in FACTS.items():
        about = [row for row in rows if row.fact == key]
        well = [row for row in about if row.verdict.word in ("agrees", "agrees within")]
        told = f"{name(key)} ({fact.claim}): {len(well)} of {len(about)} agree"
        if 0 < len(well) < len(about):
            by_model: dict[str, list[str]] = {}
            for row in well:
                by_model.setdefault(row.model, []).append(row.assumption)
            models = (f"{model} ({', '.join(names)})" for model, names in by_model.items())
            told += ": " + "; ".join(models)
        yield told + "."


def _notes(found: Findings) -> Iterator[str]:
    for one in found.peaks:
        mode = "eq. 15" if one.mode == "paper" else "feet that may stick"
        verdict = judge(FACTS["maximum below"], one.high_deg, 0.0)
        yield (
            f"Theory with {mode}: over e = {RESTITUTIONS[0]:g} to {RESTITUTIONS[-1]:g} and "
            f"μ = {FRICTIONS[0]:g} to {FRICTIONS[-1]:g} the maximum lies between {one.low_deg:g} "
            f"and {one.high_deg:g} deg; below {FACTS['maximum below'].value:g} deg: {verdict}."
        )
    for series in series_of(found.drives):
        yield from _onset(series)
    for series in series_of((*found.tilts, *found.drives)):
        yield from _lost(series)


def _lost(series: Sequence[Point]) -> Iterator[str]:
    """Lines on runs that ended badly: the means are over the others."""
    lost = sum(point.lost for point in series)
    missing = [f"{point.tilt_deg:g} deg" for point in series if point.speed is None]
    if lost:
        told = f"{series[0].assumption}, {series[0].model}: means leave out the runs that ended "
        told += f"badly, {lost} in all (the CSVs say where and how)"
        if missing:
            told += f"; none is given for {', '.join(missing)}, where they are most"
        yield told + "."


def _onset(series: Sequence[Point]) -> Iterator[str]:
    """Lines on where speeds rise most steeply with the plate's speed."""
    known = [(one.plate_speed_mm_s, one.speed) for one in series if one.speed is not None]
    rises: list[tuple[float, float, float, Value, Value]] = [
        ((b.mean - a.mean) / (y - x), x, y, a, b) for (x, a), (y, b) in pairwise(known)
    ]
    if rises:
        _, x, y, a, b = max(rises)
        yield (
            f"Figure 5, {series[0].assumption}, {series[0].model}: steepest from {x:.1f} to "
            f"{y:.1f} mm/s of the plate, where the speed goes from {number(*a)} to {number(*b)} "
            "mm/s."
        )


def _slopes(found: Findings) -> str:
    return "; ".join(
        f"{series[0].assumption}, {series[0].model} {number(slope.mean, slope.se)}"
        for series in series_of(found.drives)
        if (slope := through_zero(series)) is not None
    )
