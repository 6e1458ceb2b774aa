"""Hostile numbers for the model in space run to an honest end; refusals.toml has those that do not."""

import json

import pytest
from nightly_cases import mostly_nightly

from walkergen.core.simulation.run import Outcome

PLANE = {"arena": {"kind": "plane"}}
SHORT = {"run": {"seconds": 0.3, "discard_seconds": 0.05, "runs": 2}}
ALLOWED_OUTCOMES = {one.value for one in Outcome} - {Outcome.FAILED.value}
"""Ends that say what happened; an energy error says that the numbers are worth nothing."""


def toml(tables):
    """Text of a scene of the given tables, and of the paper's drive."""
    whole = {"drive": {"frequency_hz": 90.0, "gamma": 1.8}} | tables
    lines = ['name = "hostile"']
    for name, values in whole.items():
        lines += [f"[{name}]", *(f"{key} = {json.dumps(value)}" for key, value in values.items())]
    return "\n".join(lines) + "\n"


EDGE_SCENES = {
    "tips of 1 nm": {"feet": {"tip_radius_um": 1e-3}},
    "tips of 1 m": {"feet": {"tip_radius_um": 1e6}},
    "rigid tips": {"feet": {"rigid_tips": True}},
    "a plate of 1 kPa": {"plate": {"youngs_modulus_gpa": 1e-6}},
    "a plate of 1e4 GPa": {"plate": {"youngs_modulus_gpa": 1e4}},
    "label 1": {"contact": {"restitution": 1.0}},
    "smallest label": {"contact": {"restitution": 0.02}},
    "smallest label, rigid tips": {"contact": {"restitution": 0.02}, "feet": {"rigid_tips": True}},
    "friction 1e3": {"contact": {"friction": 1e3}},
    "no friction": {"contact": {"friction": 0.0}},
    "corners of a tenth of a leg": {"feet": {"unevenness_um": 750.0}},
    "noise up to 5 kHz": {"plate": {"noise_ratio": 0.3, "noise_band_hz": [20.0, 5_000.0]}},
    "noise of 100 times the drive": {"plate": {"noise_ratio": 100.0}},
    "a plane as large as the walker": {"arena": {"length_mm": 28.0, "width_mm": 8.0}},
    "a lane too narrow to turn in": {"arena": {"kind": "lane", "gap_mm": 8.05}},
    "a lane without end across": {"arena": {"kind": "lane", "gap_mm": 1e6}},
    "a plate of 1e9 g": {"drive": {"frequency_hz": 90.0, "gamma": 1e9}},
    "a plate of 1 GHz": {"drive": {"frequency_hz": 1e9, "gamma": 1.8}, "run": {"seconds": 0.02}},
    "a plate of 10 mHz": {"drive": {"frequency_hz": 0.01, "gamma": 1.8}},
    "legs undamped": {"legs": {"damping_ratio": 0.0}},
    "legs overdamped": {"legs": {"damping_ratio": 10.0}},
    "the coarsest step": {"run": {"step_us": 68.0}},
}
"""Scenes at the edge of what is allowed."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", mostly_nightly(EDGE_SCENES, *(name for name in EDGE_SCENES if name != "a plate of 1 GHz"))
)
def test_numbers_at_the_edge_run_to_an_honest_end(run, tmp_path, name):
    tables = PLANE | SHORT
    tables |= {table: tables.get(table, {}) | values for table, values in EDGE_SCENES[name].items()}
    (tmp_path / "scene.toml").write_text(toml(tables), encoding="utf-8")
    result = run("simulate", "--scene", "scene.toml", "--tilt", "10", "--json")
    assert result.exit_code == 0, (result.output, result.exception)
    found = json.loads(result.stdout)
    assert set(found["outcomes"]) <= ALLOWED_OUTCOMES
    assert "nan" not in result.stdout.lower()
