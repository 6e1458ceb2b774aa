"""sweep.toml: what it says, in every way that TOML has to write it, and every mistake a line."""

import re

import pytest

from walkergen.errors import InputError
from walkergen.jobs.run.sweep import ask, sweep_file
from walkergen.points.axes import Axis, Sample, Span
from walkergen.points.tolerance import Tolerance

QUOTED = """
design = "koumakis2016"
scene = "scenes/mine.toml"
printer = "ender3"
model = "compliant"
error = "5%"
seed = 3
keep = ["speed", "masses"]

[set]
"scene.drive.gamma" = 2.2
"marks.kind" = "none"

[grid]
"legs.tilt_deg" = "0:45:15"
"legs.kind" = ["flexible", "braced"]
"scene.contact.law" = "poisson,newton"
"legs.length_mm" = 7.5

[sample]
method = "latin"
points = 8

[sample.between]
"scene.contact.friction" = [0.1, 0.3]
"material.density_g_cm3" = "1:1.5"
"""
NESTED = QUOTED.replace('"scene.drive.gamma"', "scene.drive.gamma").replace('"marks.kind"', "marks.kind")
for _key in (
    "legs.tilt_deg",
    "legs.kind",
    "scene.contact.law",
    "scene.contact.friction",
    "legs.length_mm",
    "material.density_g_cm3",
):
    NESTED = NESTED.replace(f'"{_key}"', _key)


@pytest.fixture
def read(tmp_path):
    def made(text):
        path = tmp_path / "sweep.toml"
        path.write_text(text)
        return sweep_file.read(path)

    return made


@pytest.fixture
def mistakes(read, tmp_path):
    """Lines on the mistakes of a file, without its folder."""

    def told(text):
        with pytest.raises(InputError) as refused:
            read(text)
        return str(refused.value).replace(f"{tmp_path}/", "").splitlines()

    return told


@pytest.mark.parametrize("text", [QUOTED, NESTED])
def test_a_file_says_all_that_a_sweep_needs(read, tmp_path, text):
    found = read(text)
    assert (found.design, found.scene, found.printer) == ("koumakis2016", "scenes/mine.toml", "ender3")
    assert (found.model, found.error, found.seed) == ("compliant", Tolerance(0.05, True), 3)
    assert found.keep == ("speed", "masses")
    assert found.folder == tmp_path
    assert found.constants == {"scene.drive.gamma": 2.2, "marks.kind": "none"}
    axes, sample = found.space
    assert set(axes) == {
        Axis("legs.tilt_deg", (0, 15, 30, 45)),
        Axis("legs.kind", ("flexible", "braced")),
        Axis("scene.contact.law", ("poisson", "newton")),
        Axis("legs.length_mm", (7.5,)),
    }
    assert axes[0].key == "legs.tilt_deg"
    spans = (Span("scene.contact.friction", 0.1, 0.3), Span("material.density_g_cm3", 1.0, 1.5))
    assert sample == Sample(spans, 8, "latin", 3)
    assert found.space.points == 4 * 2 * 2 * 8


def test_tables_within_tables_and_inline_ones_are_the_same(read):
    rival = read('[grid]\n"legs.tilt_deg" = [1, 2]\n"legs.length_mm" = [7]')
    for text in (
        "[grid.legs]\ntilt_deg = [1, 2]\nlength_mm = [7]",
        "grid = {legs = {tilt_deg = [1, 2], length_mm = [7]}}",
        "grid.legs.tilt_deg = [1, 2]\ngrid.legs.length_mm = [7]",
    ):
        assert read(text) == rival


def test_what_is_left_out_is_left_to_others(read):
    found = read('[grid]\n"legs.tilt_deg" = "1:3:1"')
    assert (found.design, found.scene, found.model, found.error, found.keep) == (None,) * 5
    assert (found.seed, found.constants, found.space.sample) == (1, {}, None)


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ('"legs.tlit_deg" = 1', "unknown key; did you mean legs.tilt_deg?"),
        ('legs.tlit_deg = "1:2:1"', "unknown key; did you mean legs.tilt_deg?"),
        ('"scene.drive.gama" = 1', "unknown key; did you mean scene.drive.gamma?"),
        ('"legs.tilt_deg" = "0:45"', "bounds without a step are of [sample.between]"),
        ('"legs.tilt_deg" = "0:45:0"', "step 0 does not lead"),
        ('"legs.tilt_deg" = "0:1e9:1"', "more than 1000000 values"),
        ('"legs.tilt_deg" = "1,,2"', "an empty value"),
        ('"legs.tilt_deg" = []', "no values"),
        ('"legs.tilt_deg" = [1, nan]', "nan is no value"),
        ('"legs.tilt_deg" = inf', "inf is no value"),
        ('"legs.tilt_deg" = ["0:10:5", 20]', 'write one text, "0:10:5,20"'),
        ('"legs[2].friction" = "0:1:-1"', "step -1 does not lead"),
        ('"legs.tilt_deg" = 2026-01-01', "2026-01-01 is a date"),
        ('"legs.tilt_deg" = [1, 07:30:00]', "07:30:00 is a date"),
    ],
)
def test_a_mistake_in_a_grid_is_named_with_its_line(mistakes, line, told):
    (found,) = mistakes(f'seed = 1\n[grid]\n"legs.width_mm" = 3\n{line}\n"legs.foot" = "round"\n')
    assert found.startswith("sweep.toml:4: grid.")
    assert told in found


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ('"legs.tilt_deg" = 3', "write two bounds"),
        ('"legs.tilt_deg" = [1, 2, 3]', "write two bounds"),
        ('"legs.tilt_deg" = ["a", "b"]', "write two bounds"),
        ('"legs.tilt_deg" = [false, true]', "write two bounds"),
        ('"legs.tilt_deg" = "1:2:1"', "write two bounds"),
        ('"legs.tilt_deg" = [2, 1]', "must lie below"),
        ('"legs.tilt_deg" = [0, nan]', "nan is no end"),
        ('"legs.tilt_deg" = "-inf:1"', "-inf is no end"),
    ],
)
def test_a_mistake_in_bounds_is_named_with_its_line(mistakes, line, told):
    (found,) = mistakes(f"[sample]\npoints = 4\n[sample.between]\n{line}\n")
    assert found.startswith("sweep.toml:4: sample.between.legs.tilt_deg")
    assert told in found


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('modle = "space"', ":1: modle: unknown key; did you mean model?"),
        ('model = "warp"', ":1: model: 'warp': must be one of prediction, rigid"),
        ('keep = ["sped"]', ":1: keep: 'sped': must be one of speed, spread"),
        ("error = 5", ":1: error = 5: must be text, in quotes"),
        ('error = "5"', ":1: error: '5': write a positive share or speed"),
        ("seed = -1", ":1: seed = -1: must be a number >= 0"),
        ("seed = 1.5", ":1: seed = 1.5: must be a number >= 0"),
        ("design = 3", ":1: design = 3: must be text, in quotes"),
        ("grid = 3", ":1: grid = 3: must be a table [grid]"),
        ("[[grid]]\na = 1", ":1: grid = [{'a': 1}]: must be a table [grid]"),
        ("[sample]\nbetween = 3\npoints = 4", ":2: sample.between = 3: must be a table"),
        ("[sample]\npoints = 4\n[sample.between]", ":3: sample.between: 0 entries"),
        ("[sample]\npoints = 4", ":1: sample.between is missing"),
        ('[sample]\npoints = 0\nbetween = {"legs.tilt_deg" = [1, 2]}', ":2: sample.points = 0"),
        (
            '[sample]\npoints = 4\nmethod = "halton"\nbetween = {"legs.tilt_deg" = [1, 2]}',
            ":3: sample.method = 'halton': must be one of 'sobol', 'latin'",
        ),
        ("", ": the file sets nothing; write [grid]"),
        ("grid = [", ": not valid TOML"),
        ('[grid]\n"legs.tilt_deg" = 1\nlegs.tilt_deg = 2', ":2: grid.legs.tilt_deg: given twice"),
        ('[set]\n"legs.foot" = 1\n[grid]\n"legs.foot" = 1', ":4: grid.legs.foot: is in [set] too"),
    ],
)
def test_any_other_mistake_is_a_line(mistakes, text, told):
    (found,) = mistakes(text)
    assert found.startswith(f"sweep.toml{told}")


def test_all_mistakes_are_told_at_once(mistakes):
    found = mistakes('error = "much"\n[set]\n"legs.a" = 1\n[grid]\n"legs.b" = 1\n"legs.tilt_deg" = ""\n')
    assert len(found) == 4
    assert sorted(line.split(":")[1] for line in found) == ["1", "3", "5", "6"]


def test_no_such_file_is_a_line(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        sweep_file.read(tmp_path / "sweep.toml")


@pytest.mark.slow
def test_of_many_mistakes_twenty_are_told(mistakes):
    text = "[grid]\n" + "".join(f'"legs.x{number}" = 1\n' for number in range(900))
    lines = mistakes(text)
    assert len(lines) == 21
    assert lines[-1].endswith("and 880 more mistakes")


@pytest.mark.parametrize("values", ["[[]]", "{}", "[{a=1}]", "[[1, 2], 5]", "[true, 5]", '["x", 5]'])
@pytest.mark.parametrize("key", ["legs.tilt_deg", "scene.drive.gamma", "legs.kind", "scene.contact.law"])
def test_values_that_can_never_be_right_are_refused(tmp_path, key, values):
    path = tmp_path / "sweep.toml"
    path.write_text(f'[grid]\n"{key}" = {values}\n')
    with pytest.raises(InputError, match=re.escape(key)):
        ask.of_file(path).request()


def test_a_sweep_without_any_point_that_can_be_right_is_refused(tmp_path):
    path = tmp_path / "sweep.toml"
    for values in ("[90, 95]", "[5, 95]"):  # a number out of range among others is a row that says so
        path.write_text(f'[grid]\n"legs.tilt_deg" = {values}\n')
        if values == "[5, 95]":
            assert ask.of_file(path).request().space.points == 2
        else:
            with pytest.raises(InputError, match=r"none of 2 points can be right: .*legs.tilt_deg = 90"):
                ask.of_file(path).request()
