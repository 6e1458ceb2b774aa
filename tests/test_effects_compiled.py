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
    "rigid, steps": {"legs": {"model": "rigid"}, "run": {"method": "step"}},
    "rigid, steps, air": {
        "legs": {"model": "rigid"}, "run": {"method": "step"}, "effects": {"air_drag": True},
    },
    "compliant, steps": {"legs": {"model": "compliant"}},
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


@pytest.mark.slow
def test_an_effect_that_is_off_leaves_no_code(tmp_path):
    """Harmonic, air drag and leg angles each need their own sines, which must not be there; a slope
    adds numbers, and their lines.

    One test, as the scenes are compiled but once.
    """
    caches = [tmp_path / str(number) for number in range(len(SCENES))]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = dict(zip(SCENES, pool.map(compiled, SCENES.values(), caches), strict=True))
    for without, having in (
        ("relaxed", "relaxed, harmonic"), ("rigid, steps", "compliant, steps"),
        ("rigid, steps", "rigid, steps, air"),
    ):  # fmt: skip
        assert found[without][0] < found[having][0], (without, having)
        assert found[without][1] < found[having][1], (without, having)
    assert found["relaxed"][1] < found["relaxed, slope"][1]
    assert found["rigid"][1] < found["relaxed"][1]  # no flexible tensor in rigid code
