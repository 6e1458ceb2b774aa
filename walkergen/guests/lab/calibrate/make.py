"""From measurements of a calibration plate to material and contact, in a design and a scene."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress
from walkergen.core.numerics.quantity import Quantity, Verdict
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.guests.lab import drops, inverse, still_plate
from walkergen.guests.lab.calibrate import contact, form, modulus, report, specimens
from walkergen.guests.lab.calibrate.contact import Rebound
from walkergen.guests.lab.calibrate.estimate import Estimate
from walkergen.guests.lab.calibrate.form import Readings
from walkergen.guests.lab.calibrate.modulus import Bent
from walkergen.guests.lab.inverse import Answer
from walkergen.guests.lab.report import LabReport, name_after, write_report

MAX_THICKNESS_DIFFERENCE = 0.3
"""Largest relative difference of thickness between a strip and the leg that it represents."""


class Job(NamedTuple):
    """Choices of the calibrate command."""

    design: Design
    scene: Scene
    turn_deg: float
    """Deviation of pitch and roll of drops from the hand, deg."""
    drops: int
    """Simulated drops from the hand for each restitution."""
    pictures: bool
    by: str = "both"
    """Method whose modulus counts: BEND_METHOD or RING_METHOD of `specimens`, or both."""


def calibrate(path: Path, job: Job, folder: Path, progress: Progress) -> LabReport:
    """Estimate material and contact from a filled form, and write the results.

    Writes calibration.csv and .md, strips.csv, design.toml, scene.toml, strips.png and .pdf,
    manifest.json. A drop test simulates drops of the walker. Raises InputError, before anything is
    written, for readings that are unusable.
    """
    readings = form.read_form(path)
    density = contact.density(readings)
    strips, notes = specimens.from_readings(readings)
    bent = _fit_modulus(strips, density, job, notes) if strips else None
    means = {"friction": contact.friction(readings), "damping": contact.damping(readings)}
    estimates = [each for each in (*(bent.estimates if bent else ()), density, *means.values()) if each is not None]
    design, scene = _apply_settings(estimates, job, path)
    rebound, drop = contact.rebound(readings), None
    if rebound is not None:
        drop = _invert_rebound(rebound, design, scene, job, progress)
    missing = _missing_notes(readings, bent, density, means, drop)
    if drop is None and not any(each.sets for each in estimates):
        raise InputError(f"{path}: tells nothing: {'; '.join([*notes, *missing])}")
    if bent is not None:
        notes += [*_strip_notes(bent), *_leg_notes(bent, design)]
    for what, each in means.items():
        if each is not None and not each.agrees:
            notes.append(f"{what}: {', '.join(each.parts)} disagree: the error is larger by that")
    if rebound is not None and drop is not None:
        estimates, more = [*estimates, rebound.estimate, *_restitution(rebound, drop)], _drop_notes(rebound, drop)
        notes += more
        design, scene = _apply_settings(estimates, job, path)
    made = report.make_report(estimates, bent, drop, [*notes, *missing], design, scene, path, folder)
    choices = {"by": job.by, "roll_deg": job.turn_deg, "drops": job.drops, "settings": made.settings}
    return write_report(made, job, {"file": path.name, **choices}, f"Measured: {path.name}")


def _fit_modulus(strips: Sequence[specimens.Specimen], measured: Estimate | None, job: Job, notes: list[str]) -> Bent:
    """Fit the modulus of the strips; an unmeasured density is the design's. Adds to `notes`."""
    material = job.design.material
    drawn = material.density_g_cm3
    density = Quantity("density", "g_cm3", drawn, modulus.DENSITY_SD * drawn) if measured is None else measured.number
    rough = modulus.rough_moduli(strips, density)
    specimens.check_consistency(rough)
    notes += specimens.slip_notes(rough, material.youngs_modulus_gpa)
    chosen = strips if job.by == "both" else specimens.select_method(strips, job.by)
    if not chosen:
        raise InputError(f"‹by=›{job.by}: no strip has readings of that kind")
    fit, points = modulus.fit(chosen, density), modulus.fit_each_strip(strips, density)
    return Bent(fit, points, job.by, modulus.ring_excess(strips, density), modulus.thickness_offset(strips, density))


def _invert_rebound(seen: Rebound, design: Design, scene: Scene, job: Job, progress: Progress) -> Answer | None:
    """Find the feet's restitution that explains a rebound, from simulated drops with the other measured values."""
    still_plate.check_one_material(design)
    hand = drops.hand_drops(seen.height, job.turn_deg, job.drops, scene.run.seed)
    curve = drops.rebound_curve(drops.rebounds_by_restitution(scene, design, hand, progress), flat=job.turn_deg == 0.0)
    if curve is None:
        return None
    # A hand may be less sure than the one that is simulated
    curve = curve._replace(spread=np.maximum(curve.spread, seen.spread))
    return inverse.invert(curve, seen.measured, "restitution", f" at {design.tilt_deg:g} deg")


def _restitution(seen: Rebound, drop: Answer) -> list[Estimate]:
    """Estimate the feet's restitution, if a single range of it agrees with the drops."""
    number = drop.number("restitution")
    sets = ("scene.contact.restitution", "scene.contact.restitution_sd")
    tries = seen.measured.tries
    return [Estimate("restitution of the feet", number, tries, sets=sets)] if number.known else []


def _apply_settings(estimates: Sequence[Estimate], job: Job, path: Path) -> tuple[Design, Scene]:
    """Return the design and scene with the estimates, named after the file of measurements."""
    settings = report.collect_settings(estimates)
    outside = {key.removeprefix("scene."): value for key, value in settings.items() if key.startswith("scene.")}
    inside = {key: value for key, value in settings.items() if not key.startswith("scene.")}
    return _make_variant(job.design, path, inside), _make_variant(job.scene, path, outside)


def _make_variant(original: Any, path: Path, keys: Mapping[str, float]) -> Any:
    """Design or scene with these keys, named after the file of measurements."""
    description = f"As {original.name}, measured: {path.name[:200]}"
    return original.variant(**keys, name=name_after(original.name, path), description=description)


def _drop_notes(seen: Rebound, drop: Answer) -> list[str]:
    """Return the notes on a drop test, in addition to its value."""
    kept = [] if drop.number("restitution").known else ["contact.restitution stays as the scene has it"]
    value, _ = seen.measured.number.pair
    return [
        *kept,
        f"rebound {value:.3f} from {seen.height:.3g} mm, of the whole walker: "
        "the restitution is that of its feet in the model in space",
    ]


def _strip_notes(bent: Bent) -> list[str]:
    """Return notes on whether the strips agree, and on changes that would make them agree."""
    notes = []
    if not bent.fit.agrees:
        notes.append("the strips disagree beyond their errors: the error of the modulus is larger by that")
    if (ring := bent.ring_over_bend) is not None and ring.compare_with_range(0.0, 0.0) is Verdict.DISAGREE:
        excess, sd = ring.pair
        cause = (
            "creep under the weight, or a density too high"
            if excess > 0.0
            else "a clamp that gives way, or a density too low"
        )
        notes.append(
            f"the ring tells {excess:+.0f} ± {sd:.0f} % against the weights: "
            f"{cause}; legs swing as fast as the ring or faster: ‹by=›ring takes it alone"
        )
    if (offset := bent.offset) is not None and offset.compare_with_range(0.0, 0.0) is Verdict.DISAGREE:
        added, sd = offset.pair
        notes.append(
            f"{added:+.3f} ± {sd:.3f} mm on every thickness would make the strips agree "
            "best: a caliper on ridges of layers (-), or closed on nothing not at 0"
        )
    return notes


def _leg_notes(bent: Bent, design: Design) -> list[str]:
    """Note on a leg that prints thicker or thinner than drawn, by the strip that is most like it.

    It is not set: the key is also what is printed.
    """
    drawn = design.limbs[0].thickness
    near = min(bent.points, key=lambda point: abs(point.thickness.pair[0] - drawn))
    thick, sd = near.thickness.pair
    if (
        abs(thick - drawn) > MAX_THICKNESS_DIFFERENCE * drawn
        or near.thickness.compare_with_range(drawn, drawn) is not Verdict.DISAGREE
    ):
        return []
    return [
        f"{near.strip} is {thick:.3f} ± {sd:.3f} mm thick; a leg drawn "
        f"{drawn:g} mm that prints so bends {(thick / drawn) ** 3:.2f} times as stiffly: "
        "give its printed thickness to simulate it"
    ]


def _missing_notes(
    readings: Readings,
    bent: Bent | None,
    density: Estimate | None,
    means: Mapping[str, Estimate | None],
    drop: Answer | None,
) -> list[str]:
    """Return notes on quantities without an estimate, and why."""
    notes = []
    if bent is None:
        notes.append("no strip with sizes and a deflection or a ring: no Young's modulus")
    if density is None:
        lacking = [name for name in contact.DENSITY_READINGS if name not in readings.get("block", {})]
        some = len(lacking) < len(contact.DENSITY_READINGS)
        lack = f"the block lacks {', '.join(lacking)}" if some else "the block has no readings"
        assumed = f": strips count with the design's, ± {100 * modulus.DENSITY_SD:g} %" if bent is not None else ""
        notes.append(f"{lack}: no density{assumed}")
    if means["friction"] is None:
        notes.append("no slides_deg or filmed_deg of block or walker: no friction")
    if means["damping"] is None:
        notes.append("no swings_to_half of a strip: no damping of the legs")
    if "flight_s" not in readings.get("walker", {}):
        notes.append("no flight_s of the walker: no restitution")
    elif drop is None:
        notes.append(
            "the walker fell over in nearly all simulated drops: no restitution: drop it lower, or flatter (‹roll_deg›)"
        )
    return notes
