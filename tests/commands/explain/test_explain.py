"""What effects change and cost, and what can be left out: measured by pairs of runs with common random numbers."""

import json

import pytest

from walkergen.commands.explain import effect_costs, make
from walkergen.commands.simulate.request import SimulateRequest
from walkergen.core.errors import InputError
from walkergen.core.measure import Runs, measure
from walkergen.core.numerics.quantity import Verdict
from walkergen.core.scene import Scene
from walkergen.core.simulation.effects import legs
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.field_values import parse_effects
from walkergen.points import single_walker, variants
from walkergen.points.effect_selection import find_simplest
from walkergen.points.experiments import Walker
from walkergen.points.point import Point
from walkergen.points.variants import Pairs, Variant

DESIGN = Design()
LANE = Scene.model_validate({"drive": {"frequency_hz": 90.0, "gamma": 1.8}})
HELD = ["roll_and_yaw", "leg_twist"]
"""Effects that are off where one other is to be left out alone."""


def walker_of(**keys):
    return Walker(LANE.variant(**keys), DESIGN, solids.mass_of(DESIGN))


@pytest.fixture(autouse=True)
def short(monkeypatch):
    monkeypatch.setattr(variants, "MAX_RUN_S", 0.3)
    monkeypatch.setattr(variants, "MAX_DISCARD_S", 0.1)
    monkeypatch.setattr(effect_costs, "BUDGET_S", 1.0)


COMMAND = ("explain",)


def test_a_variant_that_is_the_scene_changes_nothing():
    walker = walker_of()
    pairs = Pairs(walker, (Variant("nothing", "off", walker, {}), variants.without_effect(walker, legs.TWIST_RULE)))
    done = measure(pairs, Runs(4))
    none, stiff = pairs.changes(done.records)
    assert none.speed.pair == (0.0, 0.0)
    assert stiff.speed.number != 0.0
    assert none.cpu.compare_with_range(0.5, 2.0) is not Verdict.DISAGREE
    again = measure(pairs, Runs(4), threads=1)
    assert [change.speed for change in pairs.changes(again.records)] == [none.speed, stiff.speed]


def test_every_effect_is_measured_off_or_at_its_usual_size():
    every = {
        variant.effect: variant for variant in variants.effect_variants(walker_of(**{"plate.slope_deg": 1.0}), True)
    }
    assert every["plate slope"].change == "off"
    assert every["leg twist"].leaves_out
    assert every["compliant tips"].change == "off"
    assert every["compliant tips"].leaves_out
    assert every["plate noise"].walker.scene.plate.noise_ratio > 0.0
    assert every["plate gradient"].change == "on, gradient_percent_per_mm = [0.1, 0.0]"
    assert not every["plate noise"].leaves_out
    assert {"second harmonic", "plate roughness", "air drag", "unevenness", "yaw and roll"} < set(every)
    forced = walker_of(**{"effects.off": ["leg_twist"], "feet.rigid_tips": True})
    every = {variant.effect: variant.change for variant in variants.effect_variants(forced, True)}
    assert every["leg twist"] == "on"


def test_what_is_on_is_a_line_each_and_what_is_off_one_line(run):
    lines = run("--no-cost").stdout.splitlines()
    named = [line.split("  ")[0].strip() for line in lines]
    assert "leg twist" in named
    assert "second harmonic" not in named
    assert any(line.startswith("off: second harmonic") for line in lines)
    assert len(lines) < 20
    whole = run("--no-cost", "--all").stdout
    assert "drive.second_harmonic_ratio = 0" in " ".join(whole.split())
    assert "switch plate_slope" in whole.replace("\n", "")


def test_explain_measures_and_draws(run, tmp_path):
    told = json.loads(run("--set", "scene.plate.slope_deg=1", "--measure", "--json").stdout)
    sizes = [abs(row["change_mm_s"] or 0.0) for row in told["measured"]]
    assert sizes == sorted(sizes, reverse=True)
    names = [row["effect"] for row in told["measured"]]
    assert {"plate slope", "second harmonic", "leg twist"} < set(names)
    assert any(" and " in name for name in names)
    assert told["advice"]
    folder = next((tmp_path / "out" / "explain").iterdir())
    assert {"effects.csv", "measured.csv", "explain.png", "explain.md"} <= {path.name for path in folder.iterdir()}
    rows = {row["effect"]: row for row in told["rows"]}
    assert rows["plate slope"]["cpu_ratio"] > 0.0


def test_a_sweep_leaves_out_what_its_accepted_error_allows():
    keys = {"run.runs": 1, "run.seconds": 0.05, "run.discard_seconds": 0.0, "effects.off": HELD}
    small = {"drive.second_harmonic_ratio": 1e-3}
    plain, whole, out = (
        single_walker.evaluate(Point(DESIGN, LANE.variant(**keys | more), True, ("speed",)))["speed_mm_s"]
        for more in ({}, small, small | {"run.accepted_error": 0.9})
    )
    assert out == plain != whole


def test_keys_without_a_part_are_told():
    scene = LANE.variant(**{"plate.roughness_length_mm": 2.0})
    (warning,) = make.explain(scene, DESIGN, lambda *_: None, cost=False).warnings
    assert "plate.roughness_length_mm" in warning


def test_only_what_changes_less_than_accepted_is_left_out():
    untouched = walker_of()
    assert find_simplest(untouched).walker is untouched
    keys = {"plate.slope_deg": 20.0, "drive.second_harmonic_ratio": 1e-9, "effects.off": HELD}
    found = find_simplest(walker_of(**keys | {"run.accepted_error": 0.3}))
    scene = found.walker.scene
    assert [change.effect for change in found.left_out] == ["second harmonic"]
    assert [change.effect for change in found.kept] == ["plate slope"]
    assert (scene.effects.on, scene.effects.off) == ([], [*HELD, "second_harmonic"])
    assert scene.run.accepted_error is None
    forced = find_simplest(walker_of(**keys | {"run.accepted_error": 0.3, "effects.on": ["second_harmonic"]}))
    assert forced.left_out == ()
    assert found.facts["effects"]["left_out"][0]["effect"] == "second harmonic"


ACCEPTED = {"scene.run.accepted_error": 0.9}


def test_an_accepted_error_holds_for_each_of_several_tilts_and_for_their_time():
    few = {"scene.drive.second_harmonic_ratio": 1e-3, "scene.run.discard_seconds": 0.0, "scene.effects.off": HELD}
    asked = {"tilt": "10,12", "runs": 1, "seconds": 0.05, **few}

    def told(values, **more):
        keys = {key: value for key, value in (values | more).items() if "." in key}
        plain = {key: value for key, value in values.items() if "." not in key}
        return SimulateRequest.from_values(plain | {"set": keys}).run(lambda *_: None)

    without, whole, simple = (
        told(asked, **more) for more in ({"scene.drive.second_harmonic_ratio": 0.0}, {}, ACCEPTED)
    )
    speeds = [[row["speed_mm_s"] for row in report.facts["rows"]] for report in (without, whole, simple)]
    assert speeds[0] == speeds[2] != speeds[1]
    assert [row["effects"]["left_out"][0]["effect"] for row in simple.facts["rows"]] == ["second harmonic"] * 2
    assert sum("left out: second harmonic" in line for line in simple.lines) == 2


def test_a_forecast_counts_what_an_accepted_error_leaves_out():
    keys = {"run.runs": 1, "run.seconds": 1.0, "drive.second_harmonic_ratio": 1e-9}
    scene = LANE.variant(**keys)
    accepted = find_simplest(Walker(scene.variant(**{"run.accepted_error": 0.3}), DESIGN, solids.mass_of(DESIGN)))
    assert accepted.cpu_s > 0.0
    whole, simple = (
        single_walker.cost(Point(DESIGN, scene.variant(**more), True)) for more in ({}, {"run.accepted_error": 0.3})
    )
    assert simple > whole + 0.5 * accepted.cpu_s


def test_explain_says_what_an_accepted_error_leaves_out():
    keys = {"drive.second_harmonic_ratio": 1e-9, "run.accepted_error": 0.3}
    scene = walker_of(**keys).scene
    told = make.explain(scene, DESIGN, lambda *_: None)
    assert "run.accepted_error = 0.3" in told.lines
    assert any(line.startswith("left out: second harmonic") for line in told.lines)
    assert told.facts["effects"]["left_out"][0]["effect"] == "second harmonic"
    untold = make.explain(scene, DESIGN, lambda *_: None, cost=False)
    assert any(
        line.startswith("run.accepted_error = 0.3: omitted effects are found by measurement") for line in untold.lines
    )
    assert "effects" not in untold.facts


def test_the_share_is_written_as_auto():
    assert parse_effects("auto:1%") == pytest.approx(0.01)
    assert parse_effects(0.02) == 0.02
    for wrong in ("1%", "auto:1", "auto:x%", "auto:0%", "auto"):
        with pytest.raises(ValueError, match="auto:1%"):
            parse_effects(wrong)
    with pytest.raises(InputError, match="effects="):
        SimulateRequest.from_values({"effects": "auto"}, shell=True)
