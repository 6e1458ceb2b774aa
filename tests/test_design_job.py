"""Designs for a wish: met where they are known to exist, best by a dense grid, bounded, written."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

from walkergen.errors import InputError
from walkergen.files import templates
from walkergen.jobs.make.design import box, lab, make, search, verify, wish
from walkergen.jobs.make.design.box import Box
from walkergen.jobs.make.design.lab import Bench, Job
from walkergen.jobs.make.design.wish import Wish
from walkergen.points import worker_pool
from walkergen.points.axes import Span
from walkergen.points.kinds import evaluate
from walkergen.points.point import Point
from walkergen.points.store import Store
from walkergen.points.tolerance import Tolerance
from walkergen.printing.printers import Printer
from walkergen.scene import Scene
from walkergen.walker.design import Design

SHARE = Tolerance(0.05, True)
TILT, LENGTH = Span("legs.tilt_deg", 2.0, 40.0), Span("legs.length_mm", 5.0, 10.0)


def unheard(what, done, total):
    pass


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    store = Store(tmp_path_factory.mktemp("points") / "points.sqlite")
    yield Bench(store, None, unheard)
    store.close()


def job_of(wished=None, model="prediction", spans=(TILT, LENGTH), printer="ender3", **design):
    base = templates.load("koumakis2016", "walkers", Design)
    return Job(
        wished or Wish("speed", 40.0, False, SHARE),
        lab.changed(base, templates.load("lane-90hz", "scenes", Scene), design)[0],
        templates.load("lane-90hz", "scenes", Scene),
        Box(spans),
        templates.load(printer, "printers", Printer),
        model,
        1,
    )


def predicted(job, values):
    """Predicted speed, without a search's own ways."""
    design, scene = lab.built(job, values)
    return evaluate(Point(design, scene))["speed_mm_s"]


def hidden(count, seed):
    """Known designs, on no grid."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        tilt, length, thickness = rng.uniform((4.0, 5.5, 0.36), (36.0, 9.5, 0.5))
        yield {"legs.tilt_deg": tilt, "legs.length_mm": length, "legs.flexible_thickness_mm": thickness}


@pytest.mark.nightly
def test_wishes_made_from_known_designs_are_met(bench):
    met, seen = 0, search.survey(job_of(), bench)
    speeds = [predicted(job_of(), values) for values in hidden(20, 14)]
    known = [speed for speed in speeds if speed is not None]
    assert len(known) >= 10
    for speed in known:
        job = job_of(Wish("speed", speed, False, SHARE))
        searched = search.search(job, bench, seen)
        first = searched._replace(chosen=searched.chosen[:1], expected=searched.expected[:1])
        (best,) = verify.verify(job, bench, first)
        found = evaluate(Point(Design.model_validate(tomllib.loads(best.text)), job.scene))
        met += best.met and abs(found["speed_mm_s"] - speed) <= 0.05 * speed
    assert met >= 0.9 * len(known)


@pytest.mark.slow
def test_the_fastest_is_that_of_a_dense_grid(bench):
    job = job_of(Wish("speed", None, False, SHARE))
    found = search.search(job, bench, search.survey(job, bench))
    grid = [
        predicted(job, {"legs.tilt_deg": tilt, "legs.length_mm": length})
        for tilt in np.linspace(2, 40, 39)
        for length in range(5, 11)
    ]
    # 1 %: the search has a tolerance, and a lower bound of a length at which the speed still rises
    assert found.chosen[0].seen.value >= 0.99 * max(speed for speed in grid if speed is not None)


@pytest.mark.nightly
def test_the_least_sensitive_is_that_of_finite_differences_on_a_grid(bench):
    # Steeper than the tilts at which feet stick and speeds depend on friction otherwise.
    spans = (Span("legs.tilt_deg", 16.0, 40.0), LENGTH)
    job = job_of(Wish("speed", 24.0, True, SHARE), spans=spans)
    found = search.search(job, bench, search.survey(job, bench))

    def rubbed(values, friction):
        contact = job.scene.contact.model_copy(update={"friction": friction})
        scene = job.scene.model_copy(update={"contact": contact})
        return predicted(job._replace(scene=scene), values)

    def slope(values):  # over the search's own step: a median of draws knows no finer one
        mu, step = job.scene.contact.friction, 0.05 * job.scene.contact.friction
        ends = [rubbed(values, mu + step), rubbed(values, mu - step)]
        return math.inf if None in ends else abs(ends[0] - ends[1]) / (2 * step)

    best = math.inf
    for tilt in np.linspace(16.0, 22.0, 13):
        for length in np.linspace(5.0, 10.0, 6):
            values = {"legs.tilt_deg": float(tilt), "legs.length_mm": float(length)}
            if abs((predicted(job, values) or 0.0) - 24.0) <= 1.2:
                best = min(best, slope(values))
    first = found.chosen[0]
    assert abs(first.seen.value - 24.0) <= 1.2
    assert abs(first.slope.value) == pytest.approx(slope(first.values), rel=1e-6)
    assert abs(first.slope.value) <= 1.08 * best


@pytest.mark.nightly
def test_designs_are_distinct_and_on_the_steps_that_people_write(bench, tmp_path):
    result = make.make(job_of(), bench, tmp_path, pictures=False)
    assert len(result.designs) == 3
    x = [result.job.box.place(one.values) for one in result.designs]
    apart = [np.linalg.norm(x[a] - x[b]) for a, b in ((0, 1), (0, 2), (1, 2))]
    assert min(apart) >= search.DISTINCT[1] * math.sqrt(2)
    for one in result.designs:
        tilt, length = one.values.values()
        assert (tilt, length) == (round(tilt, 1), round(length, 2))
        assert one.design.legs.tilt_deg == tilt
        assert one.design.family.tilt_deg == [tilt]


@pytest.mark.slow
def test_equal_wishes_give_equal_files_and_the_store_changes_nothing(bench, tmp_path):
    empty = Store(tmp_path / "other.sqlite")
    make.make(job_of(), bench, tmp_path / "one")
    make.make(job_of(), bench._replace(store=empty), tmp_path / "two")
    empty.close()
    names = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert {"design.csv", "design.md", "design.png", "design-1.toml", "scene-3.toml"} <= set(names)
    for name in names:
        one, two = ((tmp_path / folder / name).read_bytes() for folder in ("one", "two"))
        if name in ("design.md", "manifest.json"):  # which name their folder
            continue
        assert one == two


@pytest.mark.nightly
def test_a_scene_may_vary_and_is_written_beside_the_design(bench, tmp_path):
    spans = (TILT, Span("scene.drive.gamma", 1.2, 3.0))
    result = make.make(job_of(spans=spans), bench, tmp_path, pictures=False)
    assert result.designs[0].met
    scene = templates.load(str(tmp_path / "scene-1.toml"), "scenes", Scene)
    design = templates.load(str(tmp_path / "design-1.toml"), "walkers", Design)
    assert scene.drive.gamma == result.designs[0].values["scene.drive.gamma"]
    assert evaluate(Point(design, scene))["speed_mm_s"] == pytest.approx(40.0, abs=2.0)


@pytest.mark.slow
def test_a_drawing_is_found_from_the_new_folder(bench, tmp_path):
    (tmp_path / "bar.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="28mm" height="8mm" viewBox="0 0 28 8">'
        '<rect width="28" height="8"/></svg>'
    )
    (tmp_path / "own.toml").write_text('[body]\noutline = "bar.svg"\n')
    base = templates.load(str(tmp_path / "own.toml"), "walkers", Design)
    job = job_of(spans=(TILT,))._replace(design=base)
    make.make(job, bench, tmp_path / "elsewhere", pictures=False)
    found = templates.load(str(tmp_path / "elsewhere" / "design-1.toml"), "walkers", Design)
    assert Path(found.body.outline).is_absolute()
    assert evaluate(Point(found, job.scene))["speed_mm_s"] == pytest.approx(40.0, abs=2.0)


@pytest.mark.parametrize(
    ("speed", "side", "bound"),
    [(1e6, "largest", "has no speed without a run"), (-10.0, "smallest", "upper bound of --vary legs.tilt_deg")],
)
def test_an_impossible_speed_names_the_limit(bench, tmp_path, speed, side, bound):
    job = job_of(Wish("speed", speed, False, SHARE))
    result = make.make(job, bench, tmp_path, pictures=False)
    assert len(result.designs) == 3
    assert not any(one.met for one in result.designs)
    assert side in result.stopped
    assert bound in result.stopped
    assert "\n" not in result.stopped
    assert (tmp_path / "design-3.toml").exists()


def test_what_cannot_be_built_says_which_limit_stopped_it(bench, tmp_path):
    job = job_of(spans=(Span("legs.tilt_deg", 70.0, 85.0),), **{"legs.length_mm": 20.0})
    with pytest.raises(InputError, match=r"none of 256 designs can be made on ender3 .256 cannot be built"):
        make.make(job, bench, tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_a_printer_on_which_nothing_prints_says_why(bench, tmp_path):
    job = job_of(spans=(TILT,))
    thick = job.printer.model_copy(update={"line_width_mm": 0.8})
    with pytest.raises(InputError, match=r"256 would not print.*thinner than 0.75 printed lines"):
        make.make(job._replace(printer=thick), bench, tmp_path / "none")


@pytest.mark.slow
def test_only_what_prints_is_proposed(bench, tmp_path):
    spans = (TILT, Span("legs.flexible_thickness_mm", 0.1, 0.6))
    result = make.make(job_of(spans=spans), bench, tmp_path, pictures=False)
    feasible = result.search.survey.feasible
    assert 0 < feasible.sum() < len(feasible)
    assert all(one.design.legs.flexible_thickness_mm >= 0.3 for one in result.designs)
    assert any(one.met for one in result.designs)


def test_interrupted_nothing_is_written_and_the_same_command_goes_on_with_one_bar(tmp_path):
    store = Store(tmp_path / "points.sqlite")
    told = []

    def interrupt(what, done, total):
        told.append(done)
        if what == "first designs":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make.make(job_of(spans=(TILT,)), Bench(store, None, interrupt), tmp_path / "out")
    assert not (tmp_path / "out").exists()
    rows = store._base.execute("SELECT count(*) FROM points").fetchone()[0]
    assert rows >= 200
    assert len(set(told)) > 50  # of predictions each is told
    told.clear()
    tell = Bench(store, None, lambda what, done, total: told.append((done, total)))
    make.make(job_of(spans=(TILT,)), tell, tmp_path / "out", pictures=False)
    assert told == sorted(told)
    assert told[-1] == (100, 100)
    assert (tmp_path / "out" / "design-1.toml").exists()
    store.close()


def test_verification_never_has_the_seed_of_the_runs_that_chose():
    assert all(lab.fresh_seed(seed) != seed for seed in range(1000))
    job = job_of(model="compliant")
    design, scene = lab.built(job, {"legs.tilt_deg": 10.0, "legs.length_mm": 7.0})
    (point,) = lab.points(job, design, scene, lab.Effort(8, 2.0), None, lab.fresh_seed(1))
    assert point.scene.run.seed == lab.fresh_seed(1)


def test_marks_by_notches_do_not_forbid_tilts_between_those_of_a_family(bench):
    job = job_of(spans=(TILT,), **{"marks.kind": "notches"})
    design, _ = lab.built(job, {"legs.tilt_deg": 17.3})
    assert design.mark == "### ##"  # the first of a family of one


def test_rounding_stays_within_the_bounds():
    odd = Box((Span("legs.tilt_deg", 2.03, 39.97), Span("legs.length_mm", 5.004, 5.006)))
    assert odd.values([0.0, 0.0]) == {"legs.tilt_deg": 2.03, "legs.length_mm": 5.004}
    assert odd.values([1.0, 1.0]) == {"legs.tilt_deg": 39.97, "legs.length_mm": 5.006}
    assert odd.values([0.5, 0.5]) == {"legs.tilt_deg": 21.0, "legs.length_mm": 5.005}


@pytest.mark.parametrize(
    ("texts", "told"),
    [
        (["legs.tilt=2:40"], "did you mean legs.tilt_deg"),
        (["legs.tilt_deg"], "write KEY=VALUE"),
        (["legs.tilt_deg=10"], "write a range, legs.tilt_deg=LOW:HIGH"),
        (["legs.tilt_deg=2:40:2"], "write a range"),
        (["legs.tilt_deg=40:2"], "must lie below the second"),
        (["legs.tilt_deg=5:5"], "must lie below the second"),
        (["legs.tilt_deg=2:inf"], "write finite numbers"),
        (["legs.tilt_deg=nan:40"], "write finite numbers"),
        (["legs.tilt_deg=2:40", "legs.tilt_deg=3:4"], "given 2 times"),
        (["scene.drive.gama=1:2"], "did you mean scene.drive.gamma"),
    ],
)
def test_ranges_that_are_none_are_refused(texts, told):
    with pytest.raises(InputError, match=r"^--vary") as caught:
        box.of_options(texts, templates.load("koumakis2016", "walkers", Design))
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({}, "no wish"),
        ({"speed": math.nan}, "must be a number of mm/s"),
        ({"speed": math.inf}, "must be a number of mm/s"),
        ({"speed": 0.0}, "--error 1mm/s"),
        ({"speed": 40.0, "fastest": True}, "one wish at a time"),
        ({"speed": 40.0, "radius": 3.0}, "one wish at a time"),
        ({"fastest": True, "calm": True}, "one wish at a time"),
        ({"persistence": -3.0}, "above 0"),
        ({"turn": "up", "fastest": True}, "--turn and --fastest: one wish at a time"),
        ({"turn": "up", "calm": True}, "--turn and --least-sensitive: one wish at a time"),
        ({"turn": "down", "error": Tolerance(2.0, False)}, "no error of a rate of turning"),
    ],
)
def test_wishes_that_cannot_be_are_refused(given, told):
    usual = {"speed": None, "persistence": None, "radius": None, "turn": None, "fastest": False, "calm": False}
    with pytest.raises(InputError) as caught:
        wish.of_options(**{**usual, "error": SHARE, **given})
    assert told in str(caught.value)


def test_a_turning_radius_is_speed_over_turning_with_the_error_of_a_quotient():
    record = {
        "went": "ok",
        "model": "space",
        "runs": 8,
        "speed_mm_s": -30.0,
        "se_mm_s": 0.9,
        "turning_bias_rad_s": 0.6,
        "turning_bias_se_rad_s": 0.024,
    }
    found = wish.seen(record, "turning radius")
    assert found.value == pytest.approx(50.0)
    assert found.se == pytest.approx(50.0 * math.hypot(0.03, 0.04))
    low, high = wish.bounds(record, "turning radius")
    assert high - low == pytest.approx(2 * 1.96 * 2.5)
    assert wish.seen(record | {"turning_bias_rad_s": None}, "turning radius") is None
    assert wish.seen(record | {"turning_bias_rad_s": 0.04}, "turning radius") is None  # unresolved
    assert wish.seen(record, "persistence length") is None
    record |= {"rotational_diffusion_rad2_s": 0.02, "rotational_diffusion_se_rad2_s": 0.002}
    assert wish.seen(record, "persistence length").value == pytest.approx(1500.0)


def test_turning_up_a_slope_is_turning_down_it_with_the_other_sign():
    record = {"went": "ok", "runs": 32, "slope_turning_rad_s": -0.3, "slope_turning_se_rad_s": 0.1}
    assert wish.seen(record, "turning down the slope") == (-0.3, 0.1)
    assert wish.seen(record, "turning up the slope") == (0.3, 0.1)
    assert wish.bounds(record, "turning up the slope") == pytest.approx((0.104, 0.496))
    assert wish.seen(record | {"slope_turning_rad_s": None}, "turning up the slope") is None
    assert wish.alignment(record) is None
    known = record | {"self_alignment_per_mm": -0.02, "self_alignment_se_per_mm": 0.004}
    assert wish.alignment(known) == (-0.02, 0.004)


def test_a_wish_for_turning_by_a_slope_says_its_way():
    wished = Wish("turning up the slope", None, False, SHARE)
    assert (wished.way, wished.words, wished.slug) == ("up", "most turning up the slope", "turn-up")
    assert wished.asks_space
    assert not wished.logarithmic  # it has both signs
    assert Wish("speed", None, False, SHARE).way is None


def sloping(way, **scene):
    """Job whose walkers head all ways on a slope of 3 deg."""
    plane = templates.load("plane-90hz", "scenes", Scene)
    plane = plane.variant(**{"plate.slope_deg": 3.0, "run.heading_deg": "uniform", **scene})
    quantity = wish.TURNS[way]
    return job_of(Wish(quantity, None, False, SHARE), "space", (LENGTH,))._replace(scene=plane)


def test_a_level_plate_turns_no_heading():
    level = sloping("up", **{"plate.slope_deg": 0.0})
    with pytest.raises(InputError, match=r"^--turn up: scene.plate.slope_deg = 0: .*--set scene.plate.slope_deg=2$"):
        make.check(level)
    make.check(level._replace(box=Box((Span("scene.plate.slope_deg", 1.0, 3.0),))))


@pytest.mark.slow
def test_a_slope_turns_polar_discs_down_it(bench, tmp_path, monkeypatch):
    few = lab.Effort(8, 3.0)
    monkeypatch.setattr(lab, "TURNING", lab.Efforts(few, few, lab.Effort(16, 4.0)))
    monkeypatch.setattr(search, "FIRST", 6)
    monkeypatch.setattr(search, "NEAR", 2)
    monkeypatch.setattr(search, "ROUNDS", 1)
    disc = templates.load("polar-disc", "walkers", Design)
    thickness = Box((Span("body.thickness_mm", 2.0, 5.0),))
    job = sloping("down")._replace(design=disc, box=thickness)
    found = make.make(job, bench, tmp_path / "down", pictures=False)
    assert found.stopped == ""
    number, one = next((n, one) for n, one in enumerate(found.designs, start=1) if one.met)
    row = found.facts["rows"][number - 1]
    assert row["low_95_turning_down_rad_s"] > 0.0
    assert row["self_alignment_per_mm"] > 0.0
    design = templates.load(str(tmp_path / "down" / f"design-{number}.toml"), "walkers", Design)
    scene = templates.load(str(tmp_path / "down" / f"scene-{number}.toml"), "scenes", Scene)
    (point,) = lab.points(job, design, scene, job.efforts.verification, None, lab.fresh_seed(job.seed))
    assert wish.seen(evaluate(point), job.wish.of) == one.verified
    # No thickness turns them up, and the search says so.
    none = make.make(sloping("up")._replace(design=disc, box=thickness), bench, tmp_path / "up", pictures=False)
    assert not any(each.met for each in none.designs)
    assert "not clearly above 0" in none.stopped
    assert "a steeper slope" in none.stopped


def test_a_walker_that_never_moves_is_no_division_by_nothing(bench, tmp_path):
    still = job_of(Wish("speed", None, False, SHARE), spans=(TILT,), **{"legs.kind": "braced"})
    result = make.make(still, bench, tmp_path, pictures=False)
    assert all(abs(one.speed_mm_s) < 0.5 for one in result.designs)


@pytest.mark.slow
def test_workers_change_no_number(bench, tmp_path):
    job = job_of(spans=(TILT,))
    make.make(job, bench, tmp_path / "here")
    store = Store(tmp_path / "points.sqlite")
    with worker_pool.local(2) as two:
        make.make(job, Bench(store, two, unheard), tmp_path / "there")
    store.close()
    for name in ("design.csv", "design.png", "design-1.toml"):
        assert (tmp_path / "here" / name).read_bytes() == (tmp_path / "there" / name).read_bytes()


@pytest.mark.nightly
def test_simulated_wishes_made_from_known_designs_are_met(tmp_path):
    assert simulated_wishes(tmp_path, 20) >= 18


def simulated_wishes(folder, count):
    """Number of wishes met: speeds of known designs by the compliant model, told by own runs."""
    store, met = Store(folder / "points.sqlite"), 0
    for number, values in enumerate(hidden(count, 14)):
        job = job_of(
            model="compliant", **{"legs.flexible_thickness_mm": round(values.pop("legs.flexible_thickness_mm"), 2)}
        )
        design, scene = lab.built(job, values)
        (point,) = lab.points(job, design, scene, lab.Effort(32, 4.0), None, 77)
        speed = evaluate(point)["speed_mm_s"]
        error = Tolerance(max(0.05 * abs(speed), 0.5), False)
        job = job._replace(wish=Wish("speed", speed, False, error))
        result = make.make(job, Bench(store, None, unheard), folder / str(number), pictures=False)
        met += result.designs[0].met
    store.close()
    return met


def test_the_last_stage_of_a_search_takes_as_long_as_its_runs():
    stages = search.stages(job_of(model="space"))
    assert 0.0 < stages.survey < stages.first < stages.rounds < 1.0
    for number in range(search.ROUNDS):
        begin, end = stages.round(number)
        assert stages.first <= begin < end < stages.rounds
