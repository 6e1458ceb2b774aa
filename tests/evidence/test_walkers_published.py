"""`python -m evidence walkers-published`: templates after published work, their ranges, draws, bounds, the folder."""

import csv
import json
import math
import re
import tomllib

import numpy as np
import pytest
from typer.testing import CliRunner

import walkergen as wg
from evidence.commands import commands
from evidence.walkers_published import make, predicted, published
from evidence.walkers_published.published import SETS, STATEMENTS, Statement
from walkergen.cli import command_line
from walkergen.core.errors import InputError
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.sweep import sweep_file, sweep_setup

PAIRS = {
    "published/deseigne2010": "published/deseigne2010-plate",
    "published/son2025": "published/son2025-plate",
    "koumakis2016": "published/koumakis2016-plate",
}
SOURCE = STATEMENTS[0].source


def test_every_published_template_is_of_a_pair():
    named = set(PAIRS) | set(PAIRS.values())
    assert set(templates.published_names("walkers") + templates.published_names("scenes")) == named - {"koumakis2016"}
    assert not set(templates.names("walkers")) & set(templates.published_names("walkers"))


@pytest.mark.slow
@pytest.mark.parametrize("design", PAIRS)
def test_pairs_run_by_name(design):
    runs = wg.simulate(design, PAIRS[design], seconds=0.2, runs=4)
    assert math.isfinite(runs.speed.value)


def test_published_templates_are_listed_shown_copied_and_loaded_by_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runner = CliRunner()
    assert "published/son2025" in wg.templates()["name"]
    assert isinstance(wg.load("published/son2025"), Design)
    assert isinstance(wg.load("published/son2025-plate"), Scene)
    assert "stated" in runner.invoke(command_line, ["templates", "show", "published/son2025"]).stdout
    assert runner.invoke(command_line, ["templates", "copy", "published/son2025"]).exit_code == 0
    copied = wg.load("son2025.toml")
    assert copied == wg.load("published/son2025")
    for load in (lambda: wg.load("published/nope"), lambda: templates.load("published/nope", "walkers", Design)):
        with pytest.raises(InputError, match=r"'published/nope': no such template\. Did you mean published/"):
            load()


def own_value(section, key):
    """Value of a dotted key, entries of lists numbered from 1."""
    for name, number in re.findall(r"(\w+)(?:\[(\d+)\])?", key):
        section = getattr(section, name)
        section = section[int(number) - 1] if number else section
    return section


def text_of(name):
    """Text of a template."""
    return templates.find(name).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", SETS)
def test_ranges_hold_the_templates_values_and_stand_in_their_comments(name):
    (source,) = {each.source for each in STATEMENTS if each.source.ranges == name}
    asked = sweep_setup.from_file(source.sweep)
    design, scene = (
        wg.load(sweep_file.read_sweep(source.sweep).design),
        wg.load(sweep_file.read_sweep(source.sweep).scene),
    )
    text = text_of(sweep_file.read_sweep(source.sweep).scene) + text_of(sweep_file.read_sweep(source.sweep).design)
    for span in asked.space.sample.spans:
        value = own_value(scene if span.key.startswith("scene.") else design, span.key.removeprefix("scene."))
        assert span.low <= value <= span.high, span.key
        if name != "koumakis2016" or span.key.startswith("scene."):  # the paper's walker is older than its ranges
            key = span.key.rpartition(".")[2]
            said = rf"^{key} = .*(assumed|stated|drawn).*{span.low:g} to {span.high:g}"
            assert re.search(said, text, re.MULTILINE), span.key
    for key in (*asked.space.keys, *sweep_file.read_sweep(source.sweep).constants):
        assert own_value(scene if key.startswith("scene.") else design, key.removeprefix("scene.")) is not None, key


def test_predicted_statements_use_points_of_their_sweeps_and_the_others_state_what_is_missing():
    for statement in STATEMENTS:
        assert statement.source.read
        assert statement.source.address.startswith("https://")
        assert bool(statement.missing) != bool(statement.source.ranges)
        if statement.missing:
            continue
        axes = {axis.key: axis.values for axis in sweep_file.read_sweep(statement.source.sweep).space.axes}
        for key, value in statement.at.items():
            assert value in axes[key]
        for key, values in statement.over.items():
            assert set(values) <= set(axes[key])
    assert set(PAIRS.values()) == {
        sweep_file.read_sweep(each.source.sweep).scene for each in STATEMENTS if not each.missing
    }


def test_numbers_of_the_table_are_in_the_quoted_words():
    by = {statement.quantity: statement for statement in STATEMENTS}
    typical = 0.025 * 4.0 * 115.0  # diameters a period, mm, Hz
    disc = by["speed at 2.7 g, either way"]
    assert (disc.low, disc.high) == pytest.approx((0.94 * typical, 1.06 * typical), abs=0.05)
    assert by["speed of a printed bot of 2 mm"].low == 4 * 2.0  # its own lengths a second
    data = tomllib.loads(text_of("published/son2025-plate"))["drive"]
    assert (data["frequency_hz"], data["amplitude_um"]) == (80.0, 70.0)


def table(count, speed, grid=(2.0, 3.0), fallen=()):
    """Rows of a sweep: draws of one key, at each value of a grid."""
    for place in grid:
        for number in range(count):
            ok = number not in fallen
            yield {
                "gamma": place,
                "drawn": number / count,
                "speed_mm_s": speed(number / count, place) if ok else None,
                "status": "ok" if ok else "no speed: 4 toppled",
            }


def row_of(rows, **keys):
    """Prediction of a statement by these rows."""
    made = Statement(SOURCE, "speed", "mm/s", "here", **{"low": 50.0, "high": 60.0, **keys})
    return predicted.predict_statement(made, predicted.group_draws(("gamma", "drawn"), rows, ["gamma"]))


def test_bounds_hold_95_percent_of_the_draws_with_their_errors():
    found = row_of(table(400, lambda drawn, gamma: 100.0 * gamma * drawn), at={"gamma": 2.0})
    assert (found.low, found.median, found.high) == pytest.approx((5.0, 100.0, 195.0), abs=0.5)
    assert (found.draws, found.ran) == (400, 400)
    # of n uniform draws the error of a quantile q is sqrt(q (1 - q) / n) of the range
    assert found.high_se == pytest.approx(200.0 * math.sqrt(0.975 * 0.025 / 400), rel=0.3)


@pytest.mark.parametrize(
    ("low", "high", "told"), [(50.0, 60.0, "yes"), (190.0, 210.0, "in part"), (210.0, 220.0, "no"), (None, None, "")]
)
def test_a_published_number_is_inside_in_part_or_not(low, high, told):
    rows = table(100, lambda drawn, gamma: 200.0 * drawn)
    assert row_of(rows, at={"gamma": 2.0}, low=low, high=high).inside == told


def test_draws_that_fall_are_counted_and_too_few_have_no_bounds():
    def speed_of_draw(drawn, gamma):
        return 10.0 + drawn

    found = row_of(table(100, speed_of_draw, fallen=range(40)), at={"gamma": 3.0})
    assert (found.draws, found.ran) == (100, 60)
    assert found.low > 10.4 - 1e-9
    few = row_of(table(100, speed_of_draw, fallen=range(61)), at={"gamma": 3.0})
    assert (few.low, few.inside) == (None, "")
    assert "39 of 100 draws run" in few.note


def test_sizes_ranges_and_ratios_are_of_one_draw_each():
    def speed_of_draw(drawn, gamma):
        return -gamma * (1.0 + drawn)

    rows = list(table(80, speed_of_draw))
    assert row_of(rows, number="size", at={"gamma": 2.0}).low > 2.0
    ranged = row_of(rows, number="range", over={"gamma": [2.0, 3.0]})
    assert (ranged.low, ranged.high) == pytest.approx((40.0, 40.0))
    ratio = row_of(rows, number="ratio", at={"gamma": 2.0}, over={"gamma": [2.0, 3.0]})
    assert (ratio.low, ratio.high) == pytest.approx((0.8, 0.8))


def test_folder_names_every_source_and_the_part_read(tmp_path, monkeypatch):
    rng = np.random.default_rng(1)

    def swept(source, progress):
        space = sweep_file.read_sweep(source.sweep).space
        rows = [
            {**dict(zip(space.keys, values, strict=True)), "speed_mm_s": rng.normal(60.0, 5.0), "status": "ok"}
            for values in space.rows()
        ]
        return predicted.group_draws(space.keys, rows, [axis.key for axis in space.axes])

    monkeypatch.setattr(make, "run_sweep", swept)
    told = CliRunner().invoke(commands, ["walkers-published", "--json", "--out", str(tmp_path / "made")])
    assert told.exit_code == 0, told.output
    page = (tmp_path / "made" / "walkers_published.md").read_text(encoding="utf-8")
    rows = list(csv.DictReader((tmp_path / "made" / "walkers_published.csv").read_text(encoding="utf-8").splitlines()))
    assert len(rows) == len(STATEMENTS)
    assert {row["inside"] for row in rows} <= {"yes", "no", "in part", ""}
    assert all(bool(row["median"]) != row["note"].startswith("not predicted") for row in rows)
    for statement in STATEMENTS:
        assert statement.source.address in page
        assert statement.source.read in page
    json.loads(told.stdout)


def test_sets_are_chosen_by_name():
    assert make.parse_sets("son2025,koumakis2016") == ("koumakis2016", "son2025")
    assert make.parse_sets(None) == SETS == published.SETS
    with pytest.raises(InputError, match="--only 'nope': must be of koumakis2016, deseigne2010, son2025"):
        make.parse_sets("nope")


def test_a_full_ring_of_cards_is_refused_as_the_table_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    half = [[-22.0, -7.5], [22.0, -7.5], [22.0, 7.5], [-22.0, 7.5]]
    keys = {"speed_mm_s": 105.0, "velocity_relaxation_s": 0.1, "turning_rad_s": 0.0}
    keys |= {"rotational_diffusion_rad2_s": 0.05, "translational_diffusion_mm2_s": 20.0}
    card = {"name": "toy", "mass_g": 7.0, "inertia_g_mm2": 1260.0, "outline_mm": [half]}
    (tmp_path / "toy.json").write_text(json.dumps(card | {key: {"value": value} for key, value in keys.items()}))
    with pytest.raises(InputError, match=r"packing 0\.8"):
        wg.crowd("toy.json", count=30, arena="ring:436,400")
