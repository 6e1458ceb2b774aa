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
    "compliant, steps": {"legs": {"model": "compliant"}},
}  # fmt: skip


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """(calls of sine and cosine, lines of code) of every scene's kernel, compiled afresh."""
    script = Path(__file__).parent / "compiled_text.py"

    def read(scene):
        words = [sys.executable, str(script), json.dumps(scene)]
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path_factory.mktemp("cache"))}
        result = subprocess.run(
            words, env=environment, capture_output=True, text=True, check=True, timeout=300
        )
        return tuple(int(word) for word in result.stdout.split())

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return dict(zip(SCENES, pool.map(read, SCENES.values()), strict=True))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("without", "having"),
    [
        ("relaxed", "relaxed, harmonic"), ("relaxed", "relaxed, slope"),
        ("rigid, steps", "compliant, steps"),
    ],
)  # fmt: skip
def test_an_effect_that_is_off_calls_no_function_of_its_own(compiled, without, having):
    """Harmonic, slope and leg angles each need their own sines, which must not be there."""
    assert compiled[without][0] < compiled[having][0]
    assert compiled[without][1] < compiled[having][1]


@pytest.mark.slow
def test_rigid_code_has_no_flexible_tensor(compiled):
    assert compiled["rigid"][1] < compiled["relaxed"][1]
