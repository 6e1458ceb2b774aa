"""sweep.toml: what it says, in every way that TOML has to write it, and every mistake a line."""

import pytest

from walkergen.core.errors import InputError
from walkergen.core.tolerance import Tolerance
from walkergen.guests.sweep import sweep_file, sweep_setup
from walkergen.guests.sweep.axes import Axis, Sample, Span

QUOTED = """
design = "koumakis2016"
scene = "scenes/mine.toml"
printer = "ender3"
model = "space"
error = "5%"
seed = 3
keep = ["speed", "masses"]

[set]
"scene.drive.gamma" = 2.2
"marks.kind" = "none"

[grid]
"legs.tilt_deg" = "0:45:15"
"legs.kind" = ["flexible", "braced"]
"legs.foot" = "flat,square"
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
    "legs.foot",
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
        return sweep_file.read_sweep(path)

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
    assert (found.model, found.error, found.seed) == ("space", Tolerance(0.05, True), 3)
    assert found.keep == ("speed", "masses")
    assert found.folder == tmp_path
    assert found.constants == {"scene.drive.gamma": 2.2, "marks.kind": "none"}
    axes, sample = found.space
    assert set(axes) == {
        Axis("legs.tilt_deg", (0, 15, 30, 45)),
        Axis("legs.kind", ("flexible", "braced")),
        Axis("legs.foot", ("flat", "square")),
        Axis("legs.length_mm", (7.5,)),
    }
    assert axes[0].key == "legs.tilt_deg"
    spans = (Span("scene.contact.friction", 0.1, 0.3), Span("material.density_g_cm3", 1.0, 1.5))
    assert sample == Sample(spans, 8, "latin", 3)
    assert found.space.point_count == 4 * 2 * 2 * 8


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


def test_all_mistakes_are_told_at_once(mistakes):
    found = mistakes('error = "much"\n[set]\n"legs.a" = 1\n[grid]\n"legs.b" = 1\n"legs.tilt_deg" = ""\n')
    assert len(found) == 4
    assert sorted(line.split(":")[1] for line in found) == ["1", "3", "5", "6"]


def test_no_such_file_is_a_line(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        sweep_file.read_sweep(tmp_path / "sweep.toml")


@pytest.mark.slow
def test_of_many_mistakes_twenty_are_told(mistakes):
    text = "[grid]\n" + "".join(f'"legs.x{number}" = 1\n' for number in range(900))
    lines = mistakes(text)
    assert len(lines) == 21
    assert lines[-1].endswith("and 880 more mistakes")


def test_a_sweep_without_any_point_that_can_be_right_is_refused(tmp_path):
    path = tmp_path / "sweep.toml"
    for values in ("[90, 95]", "[5, 95]"):  # a number out of range among others is a row that says so
        path.write_text(f'[grid]\n"legs.tilt_deg" = {values}\n')
        if values == "[5, 95]":
            assert sweep_setup.from_file(path).space.point_count == 2
        else:
            with pytest.raises(InputError, match=r"all 2 points are invalid: .*legs.tilt_deg = 90"):
                sweep_setup.from_file(path)
