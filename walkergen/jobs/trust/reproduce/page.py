"""Page of the reproduction, as it could be printed in the paper's supplement."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

from walkergen.analysis.landings import QUIET_S
from walkergen.analysis.values import Value
from walkergen.files.report import Table
from walkergen.files.tables import as_markdown
from walkergen.jobs.trust.published import FACTS, judge
from walkergen.jobs.trust.reproduce.compare import Findings, Row
from walkergen.jobs.trust.reproduce.curves import peak, series_of, through_zero
from walkergen.jobs.trust.reproduce.plane import LONGER, Runs
from walkergen.jobs.trust.reproduce.report import mechanisms, name, number, side_by_side, verdict
from walkergen.jobs.trust.reproduce.sweeps import NOISE_RATIO, SHORTER, Point
from walkergen.simulation.compliant.lengths import MOST
from walkergen.theory.maximum import FRICTIONS, RESTITUTIONS

TITLE = "The paper, side by side"


def to_markdown(findings: Findings, rows: Sequence[Row], design: str) -> str:
    """Format the page: what comes out, the table, the statements, the figures."""
    measured = findings.assumptions[0]
    scene = measured.scene
    run, drive, factor = scene.run, scene.drive, scene.prediction.impact_speed_factor
    return f"""# {TITLE}

Statements of Koumakis, Gnoli, Maggi, Puglisi and Di Leonardo, *Mechanism of self-propulsion in
3D-printed active granular particles* (2016), against walkergen's theory and simulations of its own
printed geometry ({design}) on a plate shaken at {drive.frequency:g} Hz with {drive.peak_gamma:g} g
({drive.peak_speed:.1f} mm/s). Each simulated number: {run.runs} runs of {run.seconds:g} s, in space
of {SHORTER * run.seconds:g} s ({LONGER * run.seconds:g} s for figure 6), after
{run.discard_seconds:g} s discarded; seed {run.seed}; in a plane Poisson's law of restitution, with
compliant legs in steps of at most {run.step_us or 1e6 * MOST:g} µs. In space walkers run on elastic
feet ({scene.feet.damping}), of whose damping e is the label, freely on an open plane, with speeds
along their heading: this stands for a lane without walls.

## What comes out

{_listed(_agreements(rows))}

Beside the table:

{_listed(_notes(findings))}

## Table

{_table(side_by_side(rows, findings.assumptions, verdict))}

± is twice the standard error over the runs; for landings over the tilts; of the theory twice the
standard deviation that those of restitution, friction and masses give, with impact speed
w = {factor:g} x the plate's peak speed: calibrated on the paper's 60 mm/s at 10 deg, so that this
speed is no test of the theory. A number agrees when all of its ± lies within the paper's
margin ("within x": x from the stated value), differs when none of it does, and is undecided in
between. The bias of the time steps is not in ± (`walkergen accuracy` measures it).

## Three mechanisms

The paper names three ways to run: flexible tilted legs, its own; feet of different friction or
restitution; rigid legs of unequal length. Here is a walker of each ({measured.label},
but for the feet whose contact the template states), by the theory, the paper's mean of both feet or
the balance of unlike feet (docs/physics.md section 4b), and simulated (model
{findings.mechanisms[0].simulated.model}).

{_table(mechanisms(findings.mechanisms))}

± of the theory is twice the standard deviation by restitution, friction, masses and impact speed.
Direction: of the simulation against the theory's, undecided within two standard errors.
The rigid walkers were chosen so that the two have one direction: on elastic feet others run against
the theory (docs/physics.md section 4b).

![Three mechanisms](mechanisms.png)

Each walker from the side, running to the right, and its speed; bars are two standard deviations
(theory) and two standard errors (simulation).

## Statements

{_statements()}

## Figures

![Figure 2](figure2.png)

Figure 2. Speed against tilt. Star: the paper's stated peak, with our margins. Theory with
w = {factor:g} x the plate's peak speed; its band is one standard deviation. Bars are two standard
errors.

![Figure 3](figure3.png)

Figure 3. Types of impacts against tilt, with the fitted contact, counted in three ways: every
impact, chatter included; landings, a foot's first impact after {1e3 * QUIET_S:g} ms without one;
by normal impulse. In space an impact is a contact of a corner from the first force to the last, its
impulse with the weight that it bears meanwhile. As in the paper the foot's sliding speed I stays
forward, II turns backward during restitution, III during compression, IV stays backward. From rest
(exactly) is the limit of type III. The table takes the tilts above 0, for an
upright walker slides either way.

![Figure 5](figure5.png)

Figure 5. Speed against the plate's peak speed at {findings.drives[0].tilt_deg:g} deg and
{drive.frequency:g} Hz, with least-squares lines through zero; that of walkers in space is drawn for
the points from figure 2's drive up. The theory is proportional by construction. The noisy plate has
noise of {NOISE_RATIO:g} x the drive's speed (rms), from {scene.plate.noise_low_hz:g} to
{scene.plate.noise_high_hz:g} Hz: chosen, for the paper does not state its plate's. Slopes over all
points: {_slopes(findings)}.

![Figure 6](figure6.png)

Figure 6. Motion on a plane in space, with the low restitution. (a) Mean squared displacement
against lag, with guides, and its local exponents; star: the paper's crossover at 35 deg, with our
margin. (b) Tracks of {LONGER * run.seconds:g} s from one start, each turned by its own angle, those
of 35 deg magnified. (c) Densities of displacements along and across the heading over 40 ms; the
paper states no number of them. Bars and bands are two standard errors.
"""


def _table(table: Table) -> str:
    return as_markdown(table.rich(markdown=True))


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
        of_fact = [row for row in rows if row.fact == key]
        agreeing = [row for row in of_fact if row.verdict.agrees]
        line = f"{name(key)} ({fact.claim}): {len(agreeing)} of {len(of_fact)} agree"
        if 0 < len(agreeing) < len(of_fact):
            by_model: dict[str, list[str]] = {}
            for row in agreeing:
                by_model.setdefault(row.model, []).append(row.assumption)
            models = (f"{model} ({', '.join(names)})" for model, names in by_model.items())
            line += ": " + "; ".join(models)
        yield line + "."


def _notes(findings: Findings) -> Iterator[str]:
    for peaks in findings.peaks:
        mode = "eq. 15" if peaks.mode == "paper" else "feet that may stick"
        verdict = judge(FACTS["maximum below"], peaks.high_deg, 0.0)
        yield (
            f"Theory with {mode}: over e = {RESTITUTIONS[0]:g} to {RESTITUTIONS[-1]:g} and "
            f"μ = {FRICTIONS[0]:g} to {FRICTIONS[-1]:g} the maximum lies between {peaks.low_deg:g} "
            f"and {peaks.high_deg:g} deg; below {FACTS['maximum below'].value:g} deg: {verdict}."
        )
    yield from _peaks(findings)
    for series in series_of(findings.drives):
        yield from _onset(series)
    for runs in findings.plane:
        yield _moved(runs)
    for series in series_of((*findings.tilts, *findings.drives)):
        yield from _lost(series)


def _peaks(findings: Findings) -> Iterator[str]:
    """Lines on the peak in space by restitution."""
    tops = [
        f"e = {label:g}: {number(*top.height)} mm/s at {number(*top.place)} deg"
        for label, series in findings.labels.items()
        if (top := peak(series)) is not None
    ]
    if tops:
        friction = findings.assumptions[0].scene.contact.friction
        yield f"Peak in space with μ = {friction:g}, by the feet's label: {'; '.join(tops)}."


def _moved(runs: Runs) -> str:
    """Line on the displacements over 40 ms on a plane."""
    displacements = []
    for way, axis in (("along", "parallel"), ("across", "orthogonal")):
        mean, sd = (runs.motion.estimates[f"{axis}_{of}"] for of in ("mean", "sd"))
        if mean.value is not None and sd.value is not None:
            displacements.append(f"{way} {number(mean.value, mean.se)} mm, sd {number(sd.value, sd.se)} mm")
    lost = f"; {runs.lost} runs ended badly" if runs.lost else ""
    return (
        f"Figure 6, {runs.assumption}, {runs.tilt_deg:g} deg: {number(*runs.speed)} mm/s along the "
        f"heading; displacements over 40 ms {', '.join(displacements) or 'too few to tell'}{lost}."
    )


def _lost(series: Sequence[Point]) -> Iterator[str]:
    """Lines on runs that ended badly: the means are over the others."""
    lost = sum(point.lost for point in series)
    missing = [f"{point.tilt_deg:g} deg" for point in series if point.speed is None]
    if lost:
        line = f"{series[0].assumption}, {series[0].model}: means leave out the runs that ended "
        line += f"badly, {lost} in all (the CSVs say where and how)"
        if missing:
            line += f"; none is given for {', '.join(missing)}, where they are most"
        yield line + "."


def _onset(series: Sequence[Point]) -> Iterator[str]:
    """Lines on where speeds rise most steeply with the plate's speed."""
    points = [(point.plate_speed_mm_s, point.speed) for point in series if point.speed is not None]
    rises: list[tuple[float, float, float, Value, Value]] = [
        ((b.mean - a.mean) / (y - x), x, y, a, b) for (x, a), (y, b) in pairwise(points)
    ]
    if rises:
        _, x, y, a, b = max(rises)
        yield (
            f"Figure 5, {series[0].assumption}, {series[0].model}: steepest from {x:.1f} to "
            f"{y:.1f} mm/s of the plate, where the speed goes from {number(*a)} to {number(*b)} "
            "mm/s."
        )


def _slopes(findings: Findings) -> str:
    return "; ".join(
        f"{series[0].assumption}, {series[0].model} {number(slope.mean, slope.se)}"
        for series in series_of(findings.drives)
        if (slope := through_zero(series)) is not None
    )
