"""Hostile numbers for the model in space: refused in one line by name, or run to an honest end."""

import json

import pytest
from night import by_day
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.errors import WalkergenError
from walkergen.simulation.run import Outcome

PLANE = {"arena": {"kind": "plane"}}
SHORT = {"run": {"seconds": 0.3, "discard_seconds": 0.05, "runs": 2}}
HONEST = {one.value for one in Outcome} - {Outcome.FAILED.value}
"""Ends that say what happened; an energy error says that the numbers are worth nothing."""


def toml(tables):
    """Text of a scene of the given tables, and of the paper's drive."""
    whole = {"drive": {"frequency_hz": 90.0, "gamma": 1.8}} | tables
    lines = ['name = "hostile"']
    for name, values in whole.items():
        lines += [f"[{name}]", *(f"{key} = {json.dumps(value)}" for key, value in values.items())]
    return "\n".join(lines) + "\n"


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Call of `simulate` on tables of a scene, and of a walker where they are given."""
    monkeypatch.chdir(tmp_path)

    def call(scene, walker=None):
        tables = PLANE | SHORT
        for name, values in scene.items():
            tables = tables | {name: tables.get(name, {}) | values}
        (tmp_path / "scene.toml").write_text(toml(tables), encoding="utf-8")
        design = 'name = "hostile"\n'
        for name, values in (walker or {}).items():
            design += "".join([f"[{name}]\n", *(f"{k} = {json.dumps(v)}\n" for k, v in values.items())])
        (tmp_path / "walker.toml").write_text(design, encoding="utf-8")
        words = ["simulate", "walker.toml", "--scene", "scene.toml", "--tilt", "10", "--json"]
        return CliRunner().invoke(command_line, words, catch_exceptions=True)

    return call


REFUSED = {
    "tips without extent": ({"feet": {"tip_radius_um": 0.0}}, "feet.tip_radius_um = 0"),
    "tips of 1e30 um": ({"feet": {"tip_radius_um": 1e30}}, r"feet.tip_radius_um = 1e\+30"),
    "a plate without stiffness": ({"plate": {"youngs_modulus_gpa": 0.0}}, "plate.youngs_modulus_gpa = 0"),
    "a plate of no material": ({"plate": {"youngs_modulus_gpa": 0.0}}, "plate.youngs_modulus_gpa = 0"),
    "a key that is gone": ({"feet": {"stiffness_ratio": 10.0}}, "feet.stiffness_ratio.*material.youngs_modulus_gpa"),
    "no tangential stiffness": ({"feet": {"tangential_ratio": 0.0}}, "feet.tangential_ratio = 0"),
    "label 0": ({"contact": {"restitution": 0.0}}, r"contact.restitution = 0: .* give 0.02..1"),
    "label 0 of a wall": ({"arena": {"kind": "lane", "wall_restitution": 0.0}}, "arena.wall_restitution = 0"),
    "label above 1": ({"contact": {"restitution": 1.01}}, "contact.restitution = 1.01"),
    "friction below 0": ({"contact": {"friction": -0.1}}, "contact.friction = -0.1"),
    "a plane shorter than the walker": (
        {"arena": {"length_mm": 20.0}},
        r"arena.length_mm = 20: must be at least 28, .* 28 mm long; take a larger plane",
    ),
    "a plane narrower than the walker": (
        {"arena": {"width_mm": 7.9}},
        r"arena.width_mm = 7.9: must be at least 8, .* 8 mm deep; take a larger plane",
    ),
    "a lane as narrow as the walker": (
        {"arena": {"kind": "lane", "gap_mm": 8.0}},
        r"arena.gap_mm = 8: the walker is 8 mm deep and needs 8.042 mm; widen the lane",
    ),
    "a lid as low as the walker is high": (
        {"arena": {"kind": "plane", "lid_mm": 10.4}},
        r"arena.lid_mm = 10.4: the walker is 10.38\d* mm high and needs 10.5\d* mm to be let go; raise the lid",
    ),
    "a plane between walls": ({"arena": {"gap_mm": 8.5}}, "gap_mm = 8.5 has no meaning on a plane"),
    "corners as high as legs": ({"feet": {"unevenness_um": 7.6e3}}, r"feet.unevenness_um = 7600: must lie in 0..750"),
    "a band reversed": (
        {"plate": {"noise_ratio": 0.3, "noise_band_hz": [400.0, 20.0]}},
        r"noise_band_hz = \[400, 20\]: the first must lie below",
    ),
    "a band beyond what steps resolve": (
        {"plate": {"noise_ratio": 0.3, "noise_band_hz": [20.0, 20_001.0]}},
        r"plate.noise_band_hz\[2\] = 20001",
    ),
    "a band without frequencies": (
        {"plate": {"noise_ratio": 0.3, "noise_band_hz": [100.0, 100.1]}},
        r"plate.noise_band_hz = \[100, 100.1\]",
    ),
    "cliffs": ({"plate": {"roughness_um": 100.0, "roughness_length_mm": 0.1}}, "plate.roughness_um = 100"),
    "steps over contacts": ({"run": {"step_us": 100.0}}, r"run.step_us = 100: .* at most 69.*leave the key out"),
    "a model of the legs": (
        {"legs": {"model": "compliant"}},
        "legs.model.*this key is gone: every walker moves in space",
    ),
}
"""Scenes, and what the one line says."""

RUNS = {
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


@pytest.mark.parametrize("name", REFUSED)
def test_hostile_numbers_are_refused_in_one_line(run, name):
    scene, said = REFUSED[name]
    result = run(scene)
    assert isinstance(result.exception, WalkergenError), (result.output, result.exception)
    assert len(str(result.exception).splitlines()) == 1
    with pytest.raises(WalkergenError, match=said):
        raise result.exception


@pytest.mark.parametrize(
    ("walker", "said"),
    [
        ({"legs": {"flexible_thickness_mm": 0.0}}, "legs.flexible_thickness_mm = 0"),
        ({"body": {"thickness_mm": 0.0}}, "body.thickness_mm = 0"),
        ({"body": {"depth_mm": 0.0}}, "body.depth_mm = 0"),
        ({"material": {"youngs_modulus_gpa": 0.0}}, "material.youngs_modulus_gpa = 0"),
    ],
)
def test_walkers_without_extent_are_refused_in_one_line(run, walker, said):
    result = run({}, walker)
    assert isinstance(result.exception, WalkergenError), (result.output, result.exception)
    assert said in str(result.exception)
    assert len(str(result.exception).splitlines()) == 1


@pytest.mark.slow
@pytest.mark.parametrize("name", by_day(RUNS, *(name for name in RUNS if name != "a plate of 1 GHz")))
def test_numbers_at_the_edge_run_to_an_honest_end(run, name):
    result = run(RUNS[name])
    assert result.exit_code == 0, (result.output, result.exception)
    found = json.loads(result.stdout)
    assert set(found["outcomes"]) <= HONEST
    assert "nan" not in result.stdout.lower()
