"""Material and contact from measurements of a calibration plate, or from one drop, in a design and a scene."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from walkergen.core import Design, Quantity
from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress
from walkergen.core.numerics.quantity import Verdict
from walkergen.guests.lab import drops, inverse
from walkergen.guests.lab.calibrate import contact, form, modulus, report, specimens
from walkergen.guests.lab.calibrate.contact import Rebound
from walkergen.guests.lab.calibrate.estimate import Estimate
from walkergen.guests.lab.calibrate.fields import CalibrateFields
from walkergen.guests.lab.calibrate.form import Readings
from walkergen.guests.lab.calibrate.modulus import Moduli
from walkergen.guests.lab.inverse import Answer
from walkergen.guests.lab.report import LabReport, Setup, name_after, write_report

MAX_THICKNESS_DIFFERENCE = 0.3
"""Largest relative difference of thickness between a strip and the leg that it represents."""

FELL_OVER_REASON = "nearly all simulated drops fell over. Drop the walker from lower, or flatter (‹roll_deg›)"
"""Reason why drops give no restitution."""


def calibrate_form(request: CalibrateFields, setup: Setup, folder: Path, progress: Progress) -> LabReport:
    """Estimate material and contact from a filled form, and write the results.

    Writes calibration.csv and .md, strips.csv, design.toml, scene.toml, strips.png and .pdf, manifest.json. A drop test
    simulates drops of the walker. Raises InputError, before anything is written, for unusable readings.
    """
    path = Path(request.what)
    readings = form.read_form(path)
    density = contact.density(readings)
    strips, notes = specimens.from_readings(readings)
    moduli = _fit_modulus(strips, density, setup.design, request.by, notes) if strips else None
    means = {"friction": contact.friction(readings), "damping": contact.damping(readings)}
    estimates = [each for each in (*(moduli.estimates if moduli else ()), density, *means.values()) if each is not None]
    measured = _apply_settings(estimates, setup, path)
    rebound, drop = contact.rebound(readings), None
    if rebound is not None:
        drop = _invert_rebound(rebound, measured, request, progress)
    missing = _missing_notes(readings, moduli, density, means, drop)
    if drop is None and not any(each.sets for each in estimates):
        raise InputError(f"{path}: no quantity can be estimated: {'; '.join([*notes, *missing])}")
    if moduli is not None:
        notes += [*_strip_notes(moduli), *_leg_notes(moduli, measured.design)]
    for what, each in means.items():
        if each is not None and not each.agrees:
            notes.append(f"{what}: {', '.join(each.parts)} disagree, which increases its error")
    if rebound is not None and drop is not None:
        estimates += [rebound.estimate, *_restitution_estimate(rebound, drop)]
        notes += _drop_notes(rebound, drop)
        measured = _apply_settings(estimates, setup, path)
    made = report.make_report(estimates, moduli, drop, [*notes, *missing], measured, path.name, folder)
    choices = {"file": path.name, "by": request.by, "roll_deg": request.roll_deg, "drops": request.drops}
    choices["settings"] = made.settings
    return write_report(made, setup, choices, request.pictures, f"Measured: {path.name}")


def calibrate_drop(request: CalibrateFields, setup: Setup, folder: Path, progress: Progress) -> LabReport:
    """Estimate the feet's restitution from the measured rebound of a drop, and write the results.

    Writes calibration.csv and .md, manifest.json and, if the restitution is determined, scene.toml. Raises InputError
    without a rebound, and when the walker falls over in nearly all drops.
    """
    rebound = contact.stated_rebound(request)
    drop = _invert_rebound(rebound, setup, request, progress)
    if drop is None:
        raise InputError(f"‹height_mm=›{request.height_mm:g}: {FELL_OVER_REASON}")
    found = _restitution_estimate(rebound, drop)
    measured = setup._replace(scene=_apply_settings(found, setup, Path("drop")).scene) if found else setup
    title = f"Drop of {setup.design.name}, {setup.design.tilt_deg:g} deg, {setup.design.kind} legs"
    notes = _drop_notes(rebound, drop)
    made = report.make_report([rebound.estimate, *found], None, drop, notes, measured, title, folder)
    names = ("measured", "measured_sd", "tries", "height_mm", "roll_deg", "drops")
    choices = {"settings": made.settings, **{name: getattr(request, name) for name in names}}
    return write_report(made, setup, choices, request.pictures, "Measured: the rebound of a drop" if found else "")


def _fit_modulus(
    strips: Sequence[specimens.Specimen], measured: Estimate | None, design: Design, method: str, notes: list[str]
) -> Moduli:
    """Fit the modulus of the strips by `method`, with the density `measured` or else the design's. Adds to `notes`."""
    material = design.material
    drawn = material.density_g_cm3
    density = Quantity("density", "g_cm3", drawn, modulus.DENSITY_SD * drawn) if measured is None else measured.number
    rough = modulus.rough_moduli(strips, density)
    specimens.check_consistency(rough)
    notes += specimens.slip_notes(rough, material.youngs_modulus_gpa)
    chosen = strips if method == "both" else specimens.select_method(strips, method)
    if not chosen:
        raise InputError(f"‹by=›{method}: no strip has readings of this method. Use another method, or add readings")
    fit, points = modulus.fit(chosen, density), modulus.fit_each_strip(strips, density)
    return Moduli(fit, points, method, modulus.ring_excess(strips, density), modulus.thickness_offset(strips, density))


def _invert_rebound(rebound: Rebound, setup: Setup, request: CalibrateFields, progress: Progress) -> Answer | None:
    """Find the feet's restitution for a rebound from simulated drops, or None if the walker nearly always fell over."""
    scene, design = setup.scene, setup.design
    drops.check_one_restitution(design)
    hand = drops.sample_hand_drops(rebound.height, request.roll_deg, request.drops, scene.run.seed)
    rows = drops.rebounds_by_restitution(scene, design, hand, progress)
    curve = drops.rebound_curve(rows, flat=request.roll_deg == 0.0)
    if curve is None:
        return None
    # A hand may be less steady than the simulated one
    curve = curve._replace(spread=np.maximum(curve.spread, rebound.spread))
    return inverse.invert(curve, rebound.measured, "restitution", f" at {design.tilt_deg:g} deg")


def _restitution_estimate(rebound: Rebound, drop: Answer) -> list[Estimate]:
    """Return a list with the estimate of the feet's restitution; empty unless the drop gives exactly one range."""
    number = drop.number("restitution")
    sets = ("scene.contact.restitution", "scene.contact.restitution_sd")
    tries = rebound.measured.tries
    return [Estimate("restitution of the feet", number, tries, sets=sets)] if number.known else []


def _apply_settings(estimates: Sequence[Estimate], setup: Setup, path: Path) -> Setup:
    """Return design and scene with the estimates as values of their keys, named after the file of measurements."""
    settings = report.collect_settings(estimates)
    outside = {key.removeprefix("scene."): value for key, value in settings.items() if key.startswith("scene.")}
    inside = {key: value for key, value in settings.items() if not key.startswith("scene.")}
    return Setup(_make_variant(setup.design, path, inside), _make_variant(setup.scene, path, outside))


def _make_variant(original: Any, path: Path, keys: Mapping[str, float]) -> Any:
    """Return a design or scene with the values in `keys`, named after the file of measurements."""
    description = f"As {original.name}, measured: {path.name[:200]}"
    return original.variant(**keys, name=name_after(original.name, path), description=description)


def _drop_notes(seen: Rebound, drop: Answer) -> list[str]:
    """Return notes on a drop test: the rebound `seen`, and whether it sets the restitution."""
    kept = [] if drop.number("restitution").known else ["contact.restitution keeps the scene's value"]
    value, _ = seen.measured.number.pair
    return [
        *kept,
        f"rebound {value:.3f} from {seen.height:.3g} mm: it belongs to the whole walker, the restitution to its feet",
    ]


def _strip_notes(moduli: Moduli) -> list[str]:
    """Return notes on strips or methods that disagree, and on likely causes."""
    notes = []
    if not moduli.fit.agrees:
        notes.append("the strips disagree beyond their errors, which increases the error of the modulus")
    if (ring := moduli.ring_over_bend) is not None and ring.compare_with_range(low=0.0, high=0.0) is Verdict.DISAGREE:
        excess, sd = ring.pair
        cause = (
            "creep under the weight, or a density too high"
            if excess > 0.0
            else "a clamp that gives way, or a density too low"
        )
        notes.append(
            f"the modulus from the ring differs by {excess:+.0f} ± {sd:.0f} % from that under weights: {cause}. "
            "Legs swing as fast as the ring or faster; ‹by=›ring uses the ring alone"
        )
    if (offset := moduli.offset) is not None and offset.compare_with_range(low=0.0, high=0.0) is Verdict.DISAGREE:
        added, sd = offset.pair
        notes.append(
            f"{added:+.3f} ± {sd:.3f} mm on every thickness would make the strips agree best: "
            "the caliper lay on ridges of layers (-), or does not read 0 when closed"
        )
    return notes


def _leg_notes(moduli: Moduli, design: Design) -> list[str]:
    """Return a note if a leg prints thicker or thinner than drawn, from the most similar strip.

    The thickness is not set, because its key also determines the print.
    """
    drawn = design.limbs[0].thickness
    near = min(moduli.points, key=lambda point: abs(point.thickness.pair[0] - drawn))
    thick, sd = near.thickness.pair
    if (
        abs(thick - drawn) > MAX_THICKNESS_DIFFERENCE * drawn
        or near.thickness.compare_with_range(drawn, drawn) is not Verdict.DISAGREE
    ):
        return []
    return [
        f"{near.strip} is {thick:.3f} ± {sd:.3f} mm thick. A leg drawn {drawn:g} mm thick that prints like it is "
        f"{(thick / drawn) ** 3:.2f} times as stiff. Set its printed thickness to simulate it"
    ]


def _missing_notes(
    readings: Readings,
    moduli: Moduli | None,
    density: Estimate | None,
    means: Mapping[str, Estimate | None],
    drop: Answer | None,
) -> list[str]:
    """Return a note with the reason for each missing estimate. `means`: friction and damping. `drop`: restitution."""
    notes = []
    if moduli is None:
        notes.append("no Young's modulus: no strip has sizes and a deflection or a ring")
    if density is None:
        lacking = [name for name in contact.DENSITY_READINGS if name not in readings.get("block", {})]
        some = len(lacking) < len(contact.DENSITY_READINGS)
        lack = f"the block lacks {', '.join(lacking)}" if some else "the block has no readings"
        assumed = f". Strips use the design's, ± {100 * modulus.DENSITY_SD:g} %" if moduli is not None else ""
        notes.append(f"no density: {lack}{assumed}")
    if means["friction"] is None:
        notes.append("no friction: block and walker have no slides_deg or filmed_deg")
    if means["damping"] is None:
        notes.append("no damping of the legs: no strip has swings_to_half")
    if "flight_s" not in readings.get("walker", {}):
        notes.append("no restitution: the walker has no flight_s")
    elif drop is None:
        notes.append(f"no restitution: {FELL_OVER_REASON}")
    return notes
