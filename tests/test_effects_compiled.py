"""An effect that is off is absent from the compiled code: read in the text, with a cold cache."""

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

DRIVE = {"frequency_hz": 90.0, "gamma": 1.8}
SCENES = {
    "relaxed": {"legs": {"model": "relaxed"}},
    "relaxed, harmonic": {
        "legs": {"model": "relaxed"}, "drive": DRIVE | {"second_harmonic_ratio": 0.2},
    },
    "relaxed, slope": {"legs": {"model": "relaxed"}, "plate": {"slope_deg": 3.0}},
    "rigid": {"legs": {"model": "rigid"}},
    "compliant": {"legs": {"model": "compliant"}},
    "compliant, air": {"legs": {"model": "compliant"}, "effects": {"air_drag": True}},
}  # fmt: skip


def compiled(scene, cache):
    """(calls of sine and cosine, lines of code) of a scene's kernel, compiled afresh."""
    script = Path(__file__).parent / "compiled_text.py"
    words = [sys.executable, str(script), json.dumps(scene)]
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    result = subprocess.run(
        words, env=environment, capture_output=True, text=True, check=True, timeout=300
    )
    return tuple(int(word) for word in result.stdout.split())


def texts_of(scenes, folder):
    """Calls and lines of the kernels of several scenes, by their names."""
    caches = [folder / str(number) for number in range(len(scenes))]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = pool.map(compiled, (SCENES[name] for name in scenes), caches)
        return dict(zip(scenes, found, strict=True))


@pytest.mark.nightly
def test_an_effect_that_is_off_leaves_no_code(tmp_path):
    """Air drag needs its own sines, which must not be there without it."""
    found = texts_of(("compliant", "compliant, air"), tmp_path)
    assert found["compliant"][0] < found["compliant, air"][0]
    assert found["compliant"][1] < found["compliant, air"][1]


@pytest.mark.nightly
def test_drives_and_slopes_that_are_off_leave_no_code(tmp_path):
    """A harmonic needs its own sines; a slope adds numbers, and their lines."""
    scenes = [name for name in SCENES if not name.startswith("compliant")]
    found = texts_of(scenes, tmp_path)
    assert found["relaxed"][0] < found["relaxed, harmonic"][0]
    assert found["relaxed"][1] < found["relaxed, harmonic"][1]
    assert found["relaxed"][1] < found["relaxed, slope"][1]
    assert found["rigid"][1] < found["relaxed"][1]  # no flexible tensor in rigid code
