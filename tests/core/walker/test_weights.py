"""Masses from a balance: read or refused line by line, and felt by the prediction."""

import numpy as np
import pytest
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.core.errors import InputError
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.scene import Scene
from walkergen.core.walker import mass, names, solids, weighed_masses
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.points import members as predictions
from walkergen.points import model_kinds
from walkergen.points.point import Point

PAPER = templates.load("koumakis2016", "walkers", Design)
SCENE = templates.load("lane-90hz", "scenes", Scene)
MEMBERS = PAPER.members([5.0, 10.0], ["flexible"])
FIVE, TEN = "walker_t05.0_flexible_s0.40", "walker_t10.0_flexible_s0.40"


@pytest.fixture
def read_masses(tmp_path):
    def call(text: str):
        path = tmp_path / "weights.csv"
        path.write_text(text)
        return weighed_masses.read_masses(path, MEMBERS)

    return call


def predict_members(weighed, members=MEMBERS):
    built = [solids.build(member) for member in members]
    return list(predictions.predict_members(members, built, SCENE, "coulomb", weighed))


def mesh_masses(design):
    built, density = solids.build(design), 1.24e-3
    return mass.weigh(built.body, density).mass, mass.weigh(built.legs[0], density).mass


def test_copies_are_averaged_with_their_standard_error(read_masses):
    grams = [0.86, 0.88, 0.90]
    found = read_masses("part,grams\n" + "".join(f"{FIVE}-{k},{g}\n" for k, g in enumerate(grams, 1)))
    assert list(found) == [FIVE]
    error = np.std(grams, ddof=1) / np.sqrt(3)
    assert found[FIVE].grams.pair == pytest.approx((np.mean(grams), error))
    assert found[FIVE].number == 3
    assert found[FIVE].leg_g is None


def test_a_template_has_no_masses_and_can_be_filled(read_masses, tmp_path):
    text = weighed_masses.format_form([FIVE, TEN])
    with pytest.raises(InputError, match=r"no masses\. Fill in grams, body_g, leg_g"):
        read_masses(text)
    assert not weighed_masses.is_filled_in(tmp_path / "weights.csv")
    found = read_masses(text.replace(f"{TEN},,,", f"{TEN},,0.8,0.03"))
    assert weighed_masses.is_filled_in(tmp_path / "weights.csv")
    parts = (Quantity("mass", "g", grams, freedom=0.0) for grams in (0.8, 0.03))
    assert found == {TEN: weighed_masses.Weighings(None, *parts)}


@pytest.mark.parametrize("header", ["part,grams,body_g,leg_g", "part,grams"])
@pytest.mark.parametrize("line", ["x,1", "x;1", "x\t1", "x,,1,", 'x,"0,81"', "x,,, ", "x,,,\n\n", "x,,,\r", "x"])
def test_a_form_with_any_entry_is_not_overwritten(tmp_path, header, line):
    path = tmp_path / "weights.csv"
    weighed_masses.write_form(tmp_path, ["x"])
    written = f"{header}\n{line}\n".encode()
    path.write_bytes(written)
    weighed_masses.write_form(tmp_path, ["y"])
    assert path.read_bytes() == written


def test_a_sorted_form_is_not_overwritten(tmp_path):
    path = weighed_masses.write_form(tmp_path, [FIVE, TEN])
    path.write_text(ours := weighed_masses.format_form([TEN, FIVE]))
    assert weighed_masses.write_form(tmp_path, [FIVE, TEN]) == path
    assert path.read_text() == ours


def test_an_empty_template_follows_the_print(tmp_path):
    weighed_masses.write_form(tmp_path, [FIVE])
    weighed_masses.write_form(tmp_path, [TEN])
    assert (tmp_path / "weights.csv").read_text() == f"part,grams,body_g,leg_g\n{TEN},,,\n"


def test_whole_walkers_scale_all_masses_alike_and_change_the_speed_little(read_masses):
    """Only the legs' frequency depends on more than ratios of masses, by 6 % here."""
    member = predict_members(read_masses(f"part,grams\n{TEN},1.0\n"))[1]
    body, leg = mesh_masses(MEMBERS[1])
    scale = 1.0 / (body + 2 * leg)
    assert (member.row.M_g, member.row.m_g) == pytest.approx((scale * body, scale * leg))
    assert member.row.speed.value == pytest.approx(member.weighing.speed_mesh_mm_s, rel=0.1)
    assert member.weighing.mass.value == pytest.approx(1.0)
    assert member.weighing.mass_mesh_g == pytest.approx(body + 2 * leg)


@pytest.mark.parametrize(
    "cells", ["grams,body_g\n{},0.95,0.87", "grams,leg_g\n{},0.95,0.04", "body_g,leg_g\n{},0.87,0.04"]
)
def test_two_masses_of_three_give_the_same_prediction(read_masses, cells):
    member = predict_members(read_masses("part," + cells.format(TEN) + "\n"))[1]
    assert (member.row.M_g, member.row.m_g) == pytest.approx((0.87, 0.04), rel=1e-12)


def test_a_heavier_leg_changes_the_speed_as_the_same_mass_in_the_design_does(read_masses):
    first, second = predict_members(read_masses(f"part,leg_g\n{TEN},0.06\n"))
    data = MEMBERS[1].model_dump()
    data["weighed"]["leg_mass_g"] = 0.06
    (same,) = predict_members({}, [Design.model_validate(data)])
    assert second.row == same.row
    assert second.weighing.speed_mesh_mm_s != second.row.speed.value
    assert first.row.speed.value == first.weighing.speed_mesh_mm_s
    assert first.weighing.weighings == 0


def test_braced_walkers_are_weighed_whole_or_with_their_braces(tmp_path):
    (design,) = PAPER.members([10.0], ["braced"])
    path = tmp_path / "w.csv"
    path.write_text("part,grams,leg_g\nwalker_t10.0_braced_s1.00,1.1,0.1\n")
    (member,) = predict_members(weighed_masses.read_masses(path, [design]), [design])
    assert member.row.M_g == pytest.approx(1.1)
    assert member.weighing.mass.value == pytest.approx(1.1)
    assert member.row.m_g is None


def test_the_error_of_a_whole_walker_adds_those_of_its_parts(read_masses):
    rows = "".join(f"{TEN},{body},{leg}\n" for body, leg in ((0.80, 0.03), (0.82, 0.034)))
    found = read_masses("part,body_g,leg_g\n" + rows)[TEN]
    assert weighed_masses.mass_with_error(1.0, found, 2).se == pytest.approx(np.hypot(0.01, 2 * 0.002))
    assert weighed_masses.mass_with_error(1.0, read_masses(f"part,leg_g\n{TEN},0.03\n{TEN},0.04\n")[TEN], 2).se is None


def test_a_form_of_the_whole_family_serves_some_of_its_walkers(read_masses, tmp_path):
    """Walkers of other tilts and kinds are left out and named; those of no design are refused."""
    rows = [f"{name},0.9" for name in names_of_family()]
    rows += [f"{FIVE}-2,0.9", "walker_t07.5_flexible_s0.40-3,1"]
    found = read_masses("part,grams\n" + "\n".join(rows))
    assert {name: one.number for name, one in found.items()} == {FIVE: 2, TEN: 1}
    unused = weighed_masses.unused_parts(tmp_path / "weights.csv", MEMBERS)
    others = [name for name in names_of_family() if name not in (FIVE, TEN)]
    assert unused == [*others, "walker_t07.5_flexible_s0.40"]
    with pytest.raises(InputError, match="no masses of the walkers that tilt and legs select"):
        read_masses("part,grams\nwalker_t15.0_flexible_s0.40,0.9\n")


def names_of_family():
    return [names.part_name(one) for one in PAPER.members()]


def test_all_bad_lines_are_reported_together(read_masses):
    with pytest.raises(InputError) as caught:
        read_masses(f"part,grams\n{FIVE},x\nfoo,1\n{TEN},1\n{TEN},-1\n")
    assert [line.split(":")[1] for line in str(caught.value).splitlines()] == ["2", "3", "5"]


def test_files_that_cannot_be_read_are_one_line(tmp_path):
    binary = tmp_path / "b.csv"
    binary.write_bytes(b"\xff\xfe\x00")
    for path in (binary, tmp_path, tmp_path / "none.csv", tmp_path / ("x" * 300)):
        with pytest.raises(InputError) as caught:
            weighed_masses.read_masses(path, MEMBERS)
        assert len(str(caught.value).splitlines()) == 1


def test_a_spreadsheet_s_byte_order_mark_is_ignored(tmp_path):
    path = tmp_path / "w.csv"
    path.write_bytes(f"part,grams\r\n{FIVE},0.9\r\n".encode("utf-8-sig"))
    assert weighed_masses.read_masses(path, MEMBERS)[FIVE].grams.value == 0.9


@pytest.mark.parametrize("row", ["my own grain,,,", "walker,,,", "note to self,,,", f"{FIVE},,,1"])
def test_a_form_with_a_row_of_the_user_is_not_overwritten(row, tmp_path):
    path = tmp_path / weighed_masses.FILE_NAME
    path.write_text(f"{weighed_masses.format_form([FIVE, TEN])}{row}\n")
    mine = path.read_bytes()
    assert weighed_masses.write_form(tmp_path, [FIVE]) is None
    assert path.read_bytes() == mine
    path.write_text(weighed_masses.format_form([FIVE, f"{TEN}-12", f"polar-disc{FIVE.removeprefix('walker')}"]))
    assert weighed_masses.write_form(tmp_path, [TEN]) == path  # nothing but a form of ours


@pytest.mark.parametrize(
    ("key", "value", "drawn"),
    [("body_mass_g", 1e-13, "0.8333"), ("body_mass_g", 833.0, "0.8333"), ("leg_mass_g", 29.8, "0.02976")],
)
def test_masses_in_a_design_are_of_the_walker_that_it_draws(key, value, drawn):
    """A thousandth or a thousand times as much: a unit, or another part."""
    apart = rf"weighed\.{key} = .*: the mesh has {drawn} g\. They differ by more than a factor of 10"
    with pytest.raises(InputError, match=apart):
        weighed_masses.check_stated_masses(PAPER.variant(**{f"weighed.{key}": value}))
    refused = CliRunner().invoke(command_line, ["predict", "--set", f"weighed.{key}={value}"])
    assert isinstance(refused.exception, InputError)
    assert f"weighed.{key} = " in str(refused.exception)
    point = Point(PAPER.variant(**{f"weighed.{key}": value}), SCENE)
    assert model_kinds.evaluate(point)["status"].startswith(f"refused: koumakis2016: weighed.{key} = ")


def test_masses_that_a_walker_may_have_pass():
    weighed_masses.check_stated_masses(PAPER)
    weighed_masses.check_stated_masses(PAPER.variant(**{"weighed.body_mass_g": 0.87, "weighed.leg_mass_g": 0.04}))
