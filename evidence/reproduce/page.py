"""Page of the reproduction, as it could be printed in the paper's supplement."""

from collections.abc import Iterator, Sequence

from evidence.published import FACTS
from evidence.reproduce import curves
from evidence.reproduce.compare import Findings
from evidence.reproduce.maximum import FRICTIONS, RESTITUTIONS
from evidence.reproduce.motion import Runs
from evidence.reproduce.report import format_number
from evidence.reproduce.runs import FIGURE6_LENGTH_RATIO, NOISE_RATIO, SPACE_LENGTH_RATIO, Point
from walkergen.core.numerics.quantity import exact
from walkergen.files.report import Report

CAPTIONS = {
    "figure2": "Speed against tilt. Star: the paper's stated peak, with our margins. Bands are one standard deviation "
    "of the theory, bars two standard errors.",
    "figure5": "Speed against the plate's peak speed, with least-squares lines through zero; that of walkers in space "
    "is drawn for the points from figure 2's drive up. The theory is proportional by construction.",
    "figure6": "Motion on a plane in space, with the low restitution. (a) Mean squared displacement against lag, with "
    "guides. (b) Its local exponents; star: the paper's crossover at 35 deg, with our margin. (c) Tracks from one "
    "start, each turned by its own angle. (d) Densities of displacements along (thick) and across the heading over "
    "40 ms; the paper states no number of them. Bars are two standard errors.",
    "mechanisms": "Each walker from the side, running to the right, and its speed; bars are two standard deviations "
    "(theory) and two standard errors (simulation). The rigid walkers were chosen so that the two have one direction: "
    "on elastic feet others run against the theory (docs/physics.md section 4b).",
}


def to_markdown(report: Report, findings: Findings) -> str:
    """Page: the tables, what else comes out, the statements, the figures."""
    statements = [
        f"{place}. Figure {fact.figure}, {fact.where}: “{fact.quote}”. "
        f"Compared: {fact.quantity}, {fact.claim} (margin: {fact.margin})."
        for place, fact in enumerate(FACTS.values(), start=1)
    ]
    notes = [f"- {line}" for line in (*_describe_settings(findings), *_describe_results(findings))]
    pictures = [f"![{name}]({name}.png)\n\n{caption}\n" for name, caption in CAPTIONS.items()]
    parts = ("Notes", notes), ("Statements", statements), ("Figures", pictures)
    return "\n".join([report.markdown(), *(f"## {title}\n\n" + "\n".join(lines) + "\n" for title, lines in parts)])


def _describe_settings(findings: Findings) -> Iterator[str]:
    """Lines on what was simulated."""
    scene = findings.assumptions[0].scene
    run, plate, factor = scene.run, scene.plate, scene.prediction.impact_speed_factor
    yield (
        f"Plate: {scene.drive.frequency:g} Hz, {scene.drive.peak_gamma:g} g ({scene.drive.peak_speed:.1f} mm/s). Each "
        f"number: {run.runs} runs of {run.seconds:g} s, in space of {SPACE_LENGTH_RATIO * run.seconds:g} s "
        f"({FIGURE6_LENGTH_RATIO * run.seconds:g} s for figure 6), after {run.discard_seconds:g} s discarded; "
        f"seed {run.seed}."
    )
    yield (
        "The paper's model is `evidence/paper_simulation.py`. In space walkers run on elastic feet "
        f"with tips of {scene.feet.tip_radius_um:g} um, on an open plane: a lane without walls."
    )
    yield (
        f"Theory with impact speed w = {factor:g} x the plate's peak speed: calibrated on the paper's 60 mm/s at "
        "10 deg, so that this speed is no test of it. Its ± are by restitution, friction and masses."
    )
    yield (
        f"The noisy plate has noise of {NOISE_RATIO:g} x the drive's speed (rms), {plate.noise_band_hz[0]:g} to "
        f"{plate.noise_band_hz[1]:g} Hz: chosen, for the paper does not state its plate's."
    )
    yield "The bias of the time steps is not in ± (`walkergen accuracy` measures it)."


def _describe_results(findings: Findings) -> Iterator[str]:
    below = FACTS["maximum below"]
    for peaks in findings.peaks:
        yield (
            f"Theory with {'eq. 15' if peaks.mode == 'paper' else 'feet that may stick'}: over "
            f"e = {RESTITUTIONS[0]:g} to {RESTITUTIONS[-1]:g} and μ = {FRICTIONS[0]:g} to {FRICTIONS[-1]:g} the "
            f"maximum lies between {peaks.low_deg:g} and {peaks.high_deg:g} deg; below {below.value:g} deg: "
            f"{below.verdict(exact('tilt', 'deg', peaks.high_deg)).value}."
        )
    tops = [(e, curves.find_peak(series)) for e, series in findings.restitutions.items()]
    known = [f"e = {e:g}: {format_number(h)} mm/s at {format_number(at)} deg" for e, (at, h) in tops if at.value]
    if known:
        friction = findings.assumptions[0].scene.contact.friction
        yield f"Peak in space with μ = {friction:g}, by restitution: {'; '.join(known)}."
    for runs in findings.plane:
        yield _describe_displacements(runs)
    for series in curves.group_points(findings.drives):
        if (slope := curves.slope_through_zero(series)).value is not None:
            yield f"Figure 5, {series[0].assumption.name}, {series[0].model}: slope {format_number(slope)}."
    for series in curves.group_points((*findings.tilts, *findings.drives)):
        yield from _describe_lost_runs(series)


def _describe_displacements(runs: Runs) -> str:
    """Line on the displacements over 40 ms on a plane."""
    moved = []
    for way, axis in (("along", "parallel"), ("across", "orthogonal")):
        mean, sd = (runs.motion.estimates[f"{axis}_{of}"] for of in ("mean", "sd"))
        if mean.value is not None and sd.value is not None:
            moved.append(f"{way} {mean.value:.3g} mm, sd {sd.value:.3g} mm")
    lost = f"; {runs.lost} runs ended badly" if runs.lost else ""
    return (
        f"Figure 6, {runs.assumption}, {runs.tilt_deg:g} deg: {format_number(runs.speed)} mm/s along the "
        f"heading; displacements over 40 ms {', '.join(moved) or 'too few to tell'}{lost}."
    )


def _describe_lost_runs(series: Sequence[Point]) -> Iterator[str]:
    """Lines on runs that ended badly: the means are over the others."""
    lost = sum(point.lost for point in series)
    missing = [f"{point.tilt_deg:g} deg" for point in series if point.speed.value is None]
    if lost:
        line = f"{series[0].assumption.name}, {series[0].model}: means leave out the runs that ended "
        line += f"badly, {lost} in all (the CSVs say where and how)"
        yield line + (f"; none is given for {', '.join(missing)}, where they are most." if missing else ".")
