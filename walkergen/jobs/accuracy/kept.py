"""Records of measured speeds: per walker, scene, version and machine, in the user's cache."""

import hashlib
import json
from pathlib import Path

from walkergen import caches
from walkergen.errors import InputError
from walkergen.files import output, reading
from walkergen.jobs.accuracy.ladder import machine
from walkergen.jobs.accuracy.setting import Measured, Setting
from walkergen.jobs.accuracy.speeds import Survey
from walkergen.simulation import points


def record(survey: Survey) -> Path:
    """Where the measured speeds of this walker in this scene are kept, for this version here."""
    scene, *others = points.facts(survey.scene, survey.design)
    for key in ("seconds", "runs", "step_us", "accepted_error"):
        scene["run"].pop(key)
    scene["legs"].pop("model")
    text = json.dumps([scene, *others, machine()], sort_keys=True)
    return caches.folder("accuracy") / f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.json"


def remember(survey: Survey) -> None:
    """Save what the survey has measured; of two measurements of a setting the longer is kept."""
    kept = {**_kept(survey)}
    for setting, one in survey.known.items():
        other = kept.get(setting)
        if other is None or other.runs * other.seconds < one.runs * one.seconds:
            kept[setting] = one
    rows = [one._asdict() for one in kept.values()]
    output.write(record(survey), json.dumps(rows, allow_nan=False).encode())


def recall(survey: Survey) -> int:
    """Load the results of earlier surveys of the same scene; returns the number of settings."""
    kept = _kept(survey)
    survey.known |= kept
    return len(kept)


def _kept(survey: Survey) -> dict[Setting, Measured]:
    path = record(survey)
    try:
        rows = [
            Measured(**row | {"setting": Setting(*row["setting"])}) for row in reading.json_of(path)
        ]
    except (InputError, TypeError, KeyError):  # none, cut short or of another kind: measured again
        return {}
    return {one.setting: one for one in rows}
