"""From measurements of a calibration plate to material and contact, in a design and a scene."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from walkergen.analysis import inverse
from walkergen.errors import InputError
from walkergen.files import output, templates
from walkergen.files.output import Folder
from walkergen.files.progress import Progress
from walkergen.lab import drops, resting
from walkergen.lab.calibrate import contact, form, modulus, report, slips, specimens
from walkergen.lab.calibrate.contact import Rebound, Value
from walkergen.lab.calibrate.form import Readings
from walkergen.lab.calibrate.modulus import Density
from walkergen.lab.calibrate.report import CalibrationReport
from walkergen.lab.calibrate.result import Bent, Bounced, Calibrated
from walkergen.scene import Scene
from walkergen.walker.design import Design

STEEPEST_DEG, MOST_DROPS = 20.0, 1000
"""Largest deviation of a drop's first turn, and number of simulated drops from the hand."""

LIKE = 0.3
"""Relative difference of thickness up to which a strip stands for a leg."""

DIGITS = 6
"""Significant digits of a value in a file: what lies beyond is rounding."""


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
    """Method whose modulus counts: one of specimens.METHODS."""


def calibrate(path: Path, job: Job, folder: Path, progress: Progress) -> CalibrationReport:
    """Estimate material and contact from a filled form, and write all of it.

    Writes calibration.csv and .md, strips.csv, design.toml, scene.toml, strips.png and .pdf,
    manifest.json. A drop test simulates drops of the walker. Raises InputError, before anything is
    written, for readings that are unusable.
    """
    if job.by not in specimens.METHODS:
        raise InputError(f"--by {job.by[:30]!r}: must be one of {', '.join(specimens.METHODS)}")
    _check("--roll-deg", job.turn_deg, 0.0, STEEPEST_DEG)
    _check("--drops", job.drops, 2, MOST_DROPS)
    readings = form.read(path)
    density = contact.density(readings)
    bent, notes = _bent(readings, density, job)
    result = Calibrated(
        bent, density, contact.friction(readings), contact.damping(readings), None, notes, {}, job.design, job.scene
    )
    result = _with_settings(result, job, path)
    seen = contact.rebound(readings)
    if seen is not None:
        result = _with_settings(result._replace(bounced=_bounced(seen, result, job, progress)), job, path)
    missing = _missing(result, readings)
    if not result.settings and result.bounced is None:
        raise InputError(f"{path}: tells nothing: {'; '.join([*result.notes, *missing])}")
    result = result._replace(notes=[*_notes(result), *missing])
    return _written(report.of(result, path, folder), job, path)


def _check(flag: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise InputError(f"{flag} {value:g}: must lie in {low:g}..{high:g}")


def _bent(readings: Readings, measured: Value | None, job: Job) -> tuple[Bent | None, list[str]]:
    """Modulus of the strips, and notes; a density that was not measured is the design's."""
    strips, notes = specimens.read(readings)
    if not strips:
        return None, notes
    material = job.design.material
    if measured is None:
        density = Density(material.density_g_cm3, modulus.DENSITY_SD * material.density_g_cm3)
    else:
        density = Density(measured.value, measured.sd)
    inputs = strips, density
    rough = modulus.rough(*inputs)
    slips.refuse(rough)
    notes += slips.notes(rough, material.youngs_modulus_gpa)
    chosen = strips if job.by == "both" else specimens.only(strips, job.by)
    if not chosen:
        raise InputError(f"--by {job.by}: no strip has readings of that kind")
    bent = Bent(
        modulus.fit(chosen, density),
        modulus.points(*inputs),
        density,
        job.by,
        modulus.ring_over_bend(*inputs),
        modulus.offset(*inputs),
    )
    return bent, notes


def _bounced(seen: Rebound, result: Calibrated, job: Job, progress: Progress) -> Bounced | None:
    """Restitution of the feet from a rebound, by simulated drops with what else was measured."""
    resting.one_material(result.design, "restitution")
    hand = drops.from_hand(seen.height, job.turn_deg, job.drops, result.scene.run.seed)
    rows = drops.by_label(result.scene, result.design, hand, progress)
    curve = drops.curve(rows, flat=job.turn_deg == 0.0)
    if curve is None:
        return None
    # A hand may be less sure than the one that is simulated
    curve = curve._replace(spread=np.maximum(curve.spread, seen.spread))
    answer = inverse.invert(curve, seen.measured)
    ends = float(curve.at[0]), float(curve.at[-1])
    text = inverse.in_words(answer, "restitution", ends, f" at {result.design.tilt_deg:g} deg")
    return Bounced(seen, curve, answer, text)


def _with_settings(result: Calibrated, job: Job, path: Path) -> Calibrated:
    """Results with the keys that they set, and design and scene in which these are set."""
    own: dict[str, float] = {}
    if result.bent is not None:
        own["material.youngs_modulus_gpa"] = result.bent.fit.modulus
        own["material.youngs_modulus_sd_gpa"] = result.bent.fit.sd
    if result.density is not None:
        own["material.density_g_cm3"] = result.density.value
    for name, value in (("contact.friction", result.friction), ("legs.damping_ratio", result.damping)):
        if value is not None:
            own |= {f"scene.{name}": value.value, f"scene.{name}_sd": value.sd}
    if result.bounced is not None and (branch := result.bounced.single):
        own["scene.contact.restitution"] = branch.value
        own["scene.contact.restitution_sd"] = 0.5 * (branch.high - branch.low)
    own = {key: float(f"{value:.{DIGITS}g}") for key, value in own.items()}
    outside = {key.removeprefix("scene."): v for key, v in own.items() if key.startswith("scene.")}
    inside = {key: value for key, value in own.items() if not key.startswith("scene.")}
    return result._replace(
        settings=own, design=_renamed(job.design, path, inside), scene=_renamed(job.scene, path, outside)
    )


def _renamed(original: Any, path: Path, keys: Mapping[str, float]) -> Any:
    """Design or scene with these keys, named after the file of measurements."""
    name = f"{original.name[:30]}-{output.named_after(path)[:28]}"
    description = f"As {original.name}, measured: {path.name[:200]}"
    return original.variant(**keys, name=name, description=description)


def _notes(result: Calibrated) -> list[str]:
    """Notes on what the readings say beside their values."""
    notes = list(result.notes)
    if result.bent is not None:
        notes += _on_strips(result.bent)
        notes += _on_leg(result.bent, result.design)
    for what, value in (("friction", result.friction), ("damping", result.damping)):
        if value is not None and not value.agrees:
            notes.append(f"{what}: {', '.join(value.parts)} disagree: the error is larger by that")
    if result.bounced is not None:
        if result.bounced.single is None:
            notes.append("contact.restitution stays as the scene has it")
        seen = result.bounced.rebound
        notes.append(
            f"rebound {seen.measured.value:.3f} from {seen.height:.3g} mm, of the whole walker: "
            "the restitution is that of its feet in the model in space"
        )
    return notes


def _on_strips(bent: Bent) -> list[str]:
    """Notes on whether the strips agree, and on what would make them."""
    fit, notes = bent.fit, []
    if not fit.agrees:
        notes.append("the strips disagree beyond their errors: the error of the modulus is larger by that")
    if (ring := bent.ring_over_bend) is not None and ring.seen:
        cause = (
            "creep under the weight, or a density too high"
            if ring.value > 0.0
            else "a clamp that gives way, or a density too low"
        )
        notes.append(
            f"the ring tells {100 * ring.value:+.0f} ± {100 * ring.sd:.0f} % against the weights: "
            f"{cause}; legs swing as fast as the ring or faster: --by ring takes it alone"
        )
    if (off := bent.offset) is not None and off.seen:
        notes.append(
            f"{off.value:+.3f} ± {off.sd:.3f} mm on every thickness would make the strips agree "
            "best: a caliper on ridges of layers (-), or closed on nothing not at 0"
        )
    return notes


def _on_leg(bent: Bent, design: Design) -> list[str]:
    """Note on a leg that prints thicker or thinner than drawn, by the strip that is most like it.

    It is not set: the key is also what is printed.
    """
    drawn = design.limbs[0].thickness
    near = min(bent.points, key=lambda point: abs(point.thickness - drawn))
    off = near.thickness - drawn
    if abs(off) > LIKE * drawn or abs(off) <= 2.0 * near.thickness_sd:
        return []
    return [
        f"{near.strip} is {near.thickness:.3f} ± {near.thickness_sd:.3f} mm thick; a leg drawn "
        f"{drawn:g} mm that prints so bends {(near.thickness / drawn) ** 3:.2f} times as stiffly: "
        "give its printed thickness to simulate it"
    ]


def _missing(result: Calibrated, readings: Readings) -> list[str]:
    """Notes on what is not estimated, and why."""
    notes = []
    if result.bent is None:
        notes.append("no strip with sizes and a deflection or a ring: no Young's modulus")
    if result.density is None:
        lacking = contact.missing_of_density(readings)
        lack = f"the block lacks {', '.join(lacking)}" if lacking else "the block has no readings"
        assumed = (
            f": strips count with the design's, ± {100 * modulus.DENSITY_SD:g} %" if result.bent is not None else ""
        )
        notes.append(f"{lack}: no density{assumed}")
    for what, value, needs in (
        ("friction", result.friction, "slides_deg or filmed_deg of block or walker"),
        ("damping of the legs", result.damping, "swings_to_half of a strip"),
    ):
        if value is None:
            notes.append(f"no {needs}: no {what}")
    if "flight_s" not in readings.get("walker", {}):
        notes.append("no flight_s of the walker: no restitution")
    elif result.bounced is None:
        notes.append(
            "the walker fell over in nearly all simulated drops: no restitution: drop it lower, or flatter (--roll-deg)"
        )
    return notes


def _written(calibration: CalibrationReport, job: Job, path: Path) -> CalibrationReport:
    """Report, once it is written with the design and scene that go on."""
    assert calibration.folder is not None
    with Folder(calibration.folder) as target:
        calibration.write(target, job.pictures)
        comment = f"Measured: {path.name}"
        target.write("design.toml", templates.dump(calibration.design, comment, every=False).encode())
        target.write("scene.toml", templates.dump(calibration.scene, comment, every=False).encode())
        target.finish(
            {
                "file": path.name,
                "design": job.design.model_dump(mode="json"),
                "scene": job.scene.model_dump(mode="json"),
                "by": job.by,
                "roll_deg": job.turn_deg,
                "drops": job.drops,
                "settings": calibration.settings,
            }
        )
    return calibration
