"""Evaluated points: the numbers of the parts of the program that they come from, and their keys."""

import json
import math

import pytest

from walkergen.core import tolerance
from walkergen.core.errors import InputError
from walkergen.core.printing import checks
from walkergen.core.printing.printers import Printer
from walkergen.core.scene import Scene
from walkergen.core.theory import networks, prediction
from walkergen.core.theory.stationary import stationary_speed
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.sweep.axes import Space
from walkergen.guests.sweep.sweep_points import SweepPoints
from walkergen.points import experiments as simulated
from walkergen.points import model_kinds, single_walker, walkers
from walkergen.points import point as points
from walkergen.points.model_kinds import evaluate
from walkergen.points.point import PointStatus, point_key

LANE = templates.load("lane-90hz", "scenes", Scene)
PAPER = templates.load("koumakis2016", "walkers", Design)
UNEQUAL = templates.load("unequal-legs", "walkers", Design)
ENDER = templates.load("ender3", "printers", Printer)
SHORT = {"scene.run.seconds": 0.5, "scene.run.discard_seconds": 0.1, "scene.run.runs": 4}


def point_at(model="prediction", design=PAPER, keep=("speed",), error=None, printer=None, **values):
    asked = tolerance.parse_tolerance(error) if error else None
    dotted = {name.replace("__", "."): value for name, value in values.items()}
    request = SweepPoints(design, LANE, Space(()), model, keep, asked, printer)
    request.check()
    return request.point(SHORT | dotted)


def test_a_point_has_the_speed_of_predictions():
    point = point_at(keep=("speed", "spread", "masses"))
    found = evaluate(point)
    row = prediction.predict(point.design, solids.mass_of(point.design), point.scene)
    assert found["status"] == "ok"
    assert found["model"] == row.speed_by == "surrogate"
    assert (found["speed_mm_s"], found["theory_mm_s"]) == (row.speed.value, row.theory_mm_s)
    for name in (f"{end}_{level}_mm_s" for level in (68, 95) for end in ("low", "high")):
        assert found[f"predicted_{name}"] == row.columns()[f"speed_{name}"]
    assert (found["M_g"], found["J_g_mm2"]) == (row.M_g, row.J_g_mm2)
    assert (found["m_g"], found["j_g_mm2"]) == (row.m_g, row.j_g_mm2)


def test_unlike_legs_have_their_common_speed_and_the_mass_of_the_first_free_one():
    point = point_at(design=UNEQUAL, keep=("masses",))
    found, mass = evaluate(point), solids.mass_of(UNEQUAL)
    contact = LANE.contact
    each = stationary_speed(UNEQUAL, mass, contact.restitution, contact.friction, "coulomb")
    assert found["theory_mm_s"] == pytest.approx(float(each.factor) * prediction.impact_speed(LANE, mass))
    assert found["model"] == "runs"  # the surrogate has no such walker
    assert found["total_g"] == pytest.approx(float(mass.total))


def test_a_simulated_point_is_the_simulation_bit_for_bit():
    point = point_at("space", keep=("speed", "impacts"))
    found = evaluate(point)
    asked = simulated.Walker(point.scene, point.design, solids.mass_of(point.design))
    summary = walkers.simulate(asked).summary  # on every core, a point on one
    assert found["speed_mm_s"] == summary.speed.value
    assert found["se_mm_s"] == summary.speed.se
    assert found["impacts_per_s"] == summary.numbers["impacts_per_s"].value
    assert (found["runs"], found["seconds"], found["model"]) == (4, 0.5, "space")
    assert found["low_95_mm_s"] <= summary.speed.interval()[0] < found["speed_mm_s"]
    predicted = evaluate(point_at())
    assert found["theory_mm_s"] == predicted["theory_mm_s"]
    assert found["predicted_mm_s"] == predicted["speed_mm_s"]
    assert evaluate(point) == found
    assert json.loads(json.dumps(found)) == found


@pytest.mark.parametrize("error", ["4%", "2mm/s"])
def test_runs_are_added_until_the_error_is_met(error):
    found = evaluate(point_at("space", error=error))
    assert found["status"] == "ok"
    half = 0.5 * (found["high_95_mm_s"] - found["low_95_mm_s"])
    asked = tolerance.parse_tolerance(error)
    assert half <= (asked.value * abs(found["speed_mm_s"]) if asked.relative else asked.value)
    assert found["runs"] >= 8
    # An error ten times larger needs fewer runs, and the first that it tries are enough.
    assert evaluate(point_at("space", error="80%"))["runs"] == 8


TOO_SHORT = {"scene__run__seconds": 0.004, "scene__run__discard_seconds": 0.0}


def test_an_error_that_cannot_be_met_is_reported():
    found = evaluate(point_at("space", error="0.001mm/s", **TOO_SHORT))
    assert found["runs"] == 512
    assert found["went"] == PointStatus.NOT_MET
    assert found["status"].endswith("above the 0.001 requested")
    assert math.isfinite(found["speed_mm_s"])


def test_runs_that_give_no_error_are_reported():
    found = evaluate(point_at("space", scene__run__runs=2))
    assert found["status"] == "error unknown: too few data; take more runs, or longer ones"
    assert found["speed_mm_s"] > 0
    assert (found["low_95_mm_s"], found["high_95_mm_s"]) == (None, None)


def test_unrequested_columns_are_absent():
    for model, keep in (("prediction", ("speed",)), ("prediction", ("speed", "spread", "masses")), ("space", ())):
        columns = (
            single_walker.columns(model, keep)
            if keep
            else set(single_walker.SIMULATED_COLUMNS) - {"predicted_mm_s", "theory_mm_s"}
        )
        assert set(evaluate(point_at(model)._replace(keep=keep))) == {"went", "status", *columns}


def test_printability_is_what_the_checks_find():
    design = {"legs__flexible_thickness_mm": 0.2}
    found = evaluate(point_at(keep=("printability",), printer=ENDER, **design))
    point = point_at(**design)
    walker = solids.build(point.design).walker
    findings = checks.check_part("x", point.design, solids.orient_for_print(point.design, walker), ENDER)
    for level in ("error", "warning"):
        assert found[f"print_{level}s"] == sum(one.level == level for one in findings)
    assert found["print_errors"] + found["print_warnings"] > 0
    assert "\n" not in found["print_told"]
    assert evaluate(point_at(keep=("printability",), printer=ENDER))["print_errors"] == 0


def test_a_braced_walker_has_no_leg_mass():
    found = evaluate(point_at(keep=("masses",), legs__kind="braced"))
    assert (found["m_g"], found["j_g_mm2"]) == (None, None)


def test_an_impossible_point_gives_its_reason_in_one_line():
    request = SweepPoints(PAPER, LANE, Space(()))
    for values, told in (
        ({"legs.tilt_deg": 85.0}, "a leg extends"),
        ({"legs.tilt_deg": math.nan}, "legs.tilt_deg = nan"),
        ({"legs.tilt_deg": 99, "scene.contact.friction": "ice"}, "legs.tilt_deg = 99"),
        ({"scene.contact.friction": "ice"}, "contact.friction = 'ice'"),
    ):
        record = request.try_point(values)
        assert isinstance(record, dict)
        assert record["went"] == PointStatus.REFUSED
        assert record["status"] == f"refused: {record['reason']}"
        assert told in record["reason"]
        assert "\n" not in record["reason"]
    # Refused by the simulation, which first sees design and scene together.
    record = evaluate(point_at("space", scene__contact__restitution=0.0))
    assert "contact.restitution = 0" in record["reason"]


def test_printability_needs_a_printer():
    with pytest.raises(InputError, match=r"^keep=printability: needs a printer"):
        model_kinds.check(("printability",), "prediction", None)


CHANGES = {
    "tilt": {"legs__tilt_deg": 10.0000001},
    "density": {"material__density_g_cm3": 1.3},
    "friction": {"scene__contact__friction": 0.26},
    "seed": {"scene__run__seed": 2},
    "runs": {"scene__run__runs": 5},
    "prediction": {"scene__prediction__impact_speed_factor": 0.5},
    "keep": {"keep": ("speed", "masses")},
    "model": {"model": "space"},
    "error": {"model": "space", "error": "5%"},
    "share or speed": {"model": "space", "error": "0.05mm/s"},
    "printer": {"keep": ("printability",), "printer": ENDER},
    "bed": {"keep": ("printability",), "printer": ENDER.model_copy(update={"nozzle_mm": 0.31})},
}


def test_a_key_changes_with_every_input_that_matters():
    keys = {name: point_key(point_at(**change)) for name, change in CHANGES.items()}
    keys["none"] = point_key(point_at())
    assert len(set(keys.values())) == len(keys)
    assert all(len(one) == 32 for one in keys.values())


def test_a_key_does_not_change_with_names_and_order():
    plain = point_at(keep=("speed", "masses"))
    named = plain._replace(
        design=plain.design.model_copy(update={"name": "other", "description": "text"}),
        scene=plain.scene.model_copy(update={"name": "other"}),
        keep=("masses", "speed"),
    )
    assert point_key(named) == point_key(plain)
    other = ENDER.model_copy(update={"name": "other", "description": "text"})
    asked = point_at(keep=("printability",), printer=ENDER)
    assert point_key(asked._replace(printer=other)) == point_key(asked)
    # A value that is set to what it was is the same point.
    assert point_key(point_at(legs__tilt_deg=PAPER.tilt_deg)) == point_key(point_at())


def test_a_key_changes_with_the_program(monkeypatch):
    before = point_key(point_at())
    monkeypatch.setattr(points, "digest", lambda: "another")
    assert point_key(point_at()) != before


def test_a_new_table_of_predictions_forgets_no_runs(monkeypatch):
    changed = [point_at(), point_at("space")]
    kept = point_at("space")._replace(keep=())
    before, same = [point_key(one) for one in changed], point_key(kept)
    monkeypatch.setattr(networks, "digest", lambda: "another")
    assert all(point_key(one) != old for one, old in zip(changed, before, strict=True))
    assert point_key(kept) == same
    assert "predicted_mm_s" not in evaluate(point_at("space")._replace(keep=()))


def test_a_step_is_halved_down_to_the_finest():
    def walker(**run):
        point = point_at("space", **{f"scene__run__{key}": value for key, value in run.items()})
        return simulated.Walker(point.scene, point.design, solids.mass_of(point.design))

    assert walker(step_us=2.0).finer().scene.run.step_us == pytest.approx(1.0)
    assert walker(step_us=0.09).finer() is None


def test_an_error_of_the_time_in_contact_is_met():
    point = point_at("space")
    asked = simulated.Walker(point.scene, point.design, solids.mass_of(point.design))
    found = walkers.simulate_to_error(asked, tolerance.parse_tolerance("20%"), "contact_fraction")
    assert found.error <= found.allowed == 0.2 * found.results.summary.numbers["contact_fraction"].value
    assert found.error >= found.results.summary.numbers["contact_fraction"].bias > 0.0


def test_a_kind_that_is_not_installed_names_its_extra(monkeypatch):
    monkeypatch.setitem(model_kinds.KIND_MODULES, "crowd", "walkergen.nowhere")
    with pytest.raises(InputError, match=r"pip install 'walkergen\[crowd\]'"):
        model_kinds.load_kind("crowd")
