"""What effects change and cost, and what can be left out: measured by pairs of runs with common random numbers."""

import json
from types import SimpleNamespace

import numpy as np
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
from walkergen.points import effect_selection, single_walker, variants
from walkergen.points.effect_selection import find_simplest
from walkergen.points.experiments import Walker
from walkergen.points.point import Point
from walkergen.points.store import Store
from walkergen.points.variants import Pairs, Variant

DESIGN = Design()
LANE = Scene.model_validate({"drive": {"frequency_hz": 90.0, "gamma": 1.8}})
HELD = ["roll_and_yaw", "leg_twist"]
"""Effects that are off where one other is to be left out alone."""


def walker_of(**keys):
    return Walker(LANE.variant(**keys), DESIGN, solids.mass_of(DESIGN))


@pytest.fixture
def always_measured(monkeypatch):
    """Effects are measured for any simulation, and until each is decided."""
    monkeypatch.setattr(effect_selection, "MAX_PILOT_SHARE", 1e9)
    monkeypatch.setattr(effect_selection, "MAX_SPENT_SHARE", 1e9)


@pytest.fixture(autouse=True)
def short(monkeypatch, tmp_path):
    monkeypatch.setattr(effect_selection, "Store", lambda: Store(tmp_path / "points.sqlite"))
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


def test_a_sweep_leaves_out_what_its_accepted_error_allows(always_measured):
    keys = {"run.runs": 1, "run.seconds": 0.05, "run.discard_seconds": 0.0, "effects.off": HELD}
    small = {"plate.noise_ratio": 1e-6}
    plain, whole, out = (
        single_walker.evaluate(Point(DESIGN, LANE.variant(**keys | more), True, ("speed",)))["speed_mm_s"]
        for more in ({}, small, small | {"run.accepted_error": 0.9})
    )
    assert out == plain != whole


def test_keys_without_a_part_are_told():
    scene = LANE.variant(**{"plate.roughness_length_mm": 2.0})
    (warning,) = make.explain(scene, DESIGN, lambda *_: None, cost=False).warnings
    assert "plate.roughness_length_mm" in warning


NOISE = {"plate.noise_ratio": 1e-6, "effects.off": HELD}
"""Noise that takes half of the time and changes the last digits alone."""


def test_only_what_takes_time_and_changes_less_than_accepted_is_left_out(always_measured):
    untouched = walker_of()
    assert find_simplest(untouched).walker is untouched
    keys = NOISE | {"plate.slope_deg": 20.0, "run.accepted_error": 0.3}
    found = find_simplest(walker_of(**keys))
    scene = found.walker.scene
    assert [change.effect for change in found.left_out] == ["plate noise"]
    assert (scene.effects.on, scene.effects.off) == ([], [*HELD, "plate_noise"])
    assert scene.run.accepted_error is None
    assert found.cpu_s > 0.0
    again = find_simplest(walker_of(**keys))
    assert (again.walker.scene, again.lines, again.facts) == (scene, found.lines, found.facts)
    assert again.cpu_s == 0.0
    forced = find_simplest(walker_of(**keys | {"effects.on": ["plate_noise"]}))
    assert forced.left_out == ()
    assert found.facts["effects"]["left_out"][0]["effect"] == "plate noise"


def test_a_simulation_too_short_to_gain_measures_nothing():
    walker = walker_of(**NOISE | {"run.accepted_error": 0.3})
    cheap = find_simplest(walker, simulated_s=5.0)
    assert (cheap.left_out, cheap.kept, cheap.cpu_s) == ((), (), 0.0)
    assert cheap.lines[0][1].startswith("nothing to gain: measuring the effects takes")
    assert find_simplest(walker, simulated_s=1e4).left_out


@pytest.mark.parametrize("ratio", [1.0, 3.0])
def test_an_effect_that_changes_the_scatter_of_runs_is_found(ratio):
    """Pairs whose means agree: their standard deviations differ by `ratio`; 5 % of equal ones seem to differ."""
    rng, found = np.random.default_rng(1), 0
    for _ in range(200):
        common, own = rng.normal(50.0, 1.0, 16), rng.normal(0.0, 1.0, (2, 16))
        with_it, without = common + own[0], common + own[1]
        without = without.mean() + ratio * (without - without.mean())
        pairs = [tuple(SimpleNamespace(speed=speed) for speed in pair) for pair in zip(with_it, without, strict=True)]
        found += variants._scatter_change(pairs) is not None
    assert (found / 200 < 0.1) if ratio == 1.0 else (found / 200 > 0.95)


def test_the_bounds_include_what_was_left_out(always_measured):
    keys = NOISE | {"run.runs": 4, "run.seconds": 0.2, "run.discard_seconds": 0.1}
    keys = {f"scene.{key}": value for key, value in keys.items()}
    without, simple = (
        SimulateRequest.from_values({"tilt": "10", "set": keys | more}).run(lambda *_: None)
        for more in ({"scene.plate.noise_ratio": 0.0}, {"scene.run.accepted_error": 0.9})
    )
    (left_out,) = simple.facts["effects"]["left_out"]
    assert simple.facts["speed_mm_s"] == without.facts["speed_mm_s"]
    widths = [report.facts["speed_high_95_mm_s"] - report.facts["speed_low_95_mm_s"] for report in (without, simple)]
    own_error = (0.5 * widths[1] - abs(left_out["mm_s"])) ** 2 - (0.5 * widths[0]) ** 2  # squared, of the change
    assert own_error > (1.96 * left_out["se"]) ** 2
    assert "omitted effects" in str(simple)


ACCEPTED = {"scene.run.accepted_error": 0.9}


def test_an_accepted_error_holds_for_each_of_several_tilts_and_for_their_time(always_measured):
    few = {"scene.plate.noise_ratio": 1e-6, "scene.run.discard_seconds": 0.0, "scene.effects.off": HELD}
    asked = {"tilt": "10,12", "runs": 1, "seconds": 0.05, **few}

    def told(values, **more):
        keys = {key: value for key, value in (values | more).items() if "." in key}
        plain = {key: value for key, value in values.items() if "." not in key}
        return SimulateRequest.from_values(plain | {"set": keys}).run(lambda *_: None)

    without, whole, simple = (told(asked, **more) for more in ({"scene.plate.noise_ratio": 0.0}, {}, ACCEPTED))
    speeds = [[row["speed_mm_s"] for row in report.facts["rows"]] for report in (without, whole, simple)]
    assert speeds[0] == speeds[2] != speeds[1]
    assert [row["effects"]["left_out"][0]["effect"] for row in simple.facts["rows"]] == ["plate noise"] * 2
    assert sum("left out: plate noise" in line for line in simple.lines) == 2


def test_a_forecast_keeps_what_it_measured(always_measured):
    scene = LANE.variant(**NOISE | {"run.runs": 1, "run.seconds": 1.0})
    point = Point(DESIGN, scene.variant(**{"run.accepted_error": 0.3}), True)
    assert single_walker.cost(point) > 0.0
    simple = find_simplest(Walker(point.scene, DESIGN, solids.mass_of(DESIGN)))
    assert simple.cpu_s == 0.0
    assert simple.left_out


def test_explain_says_what_an_accepted_error_leaves_out(always_measured):
    scene = walker_of(**NOISE | {"run.accepted_error": 0.3}).scene
    told = make.explain(scene, DESIGN, lambda *_: None)
    assert "run.accepted_error = 0.3" in told.lines
    assert any(line.startswith("left out: plate noise") for line in told.lines)
    assert told.facts["effects"]["left_out"][0]["effect"] == "plate noise"
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
