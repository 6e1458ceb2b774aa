"""Serial numbers: every copy is engraved with its own, and bears it in files, maps and forms."""

import numpy as np
import pytest
import threemf
from command_checks import rows_of

from walkergen.commands.plate import make as batch
from walkergen.commands.plate.request import PlateRequest
from walkergen.core.errors import GeometryError
from walkergen.core.printing.printers import Printer
from walkergen.core.shapes import modeller
from walkergen.core.walker import names, solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.readers.walkers import marks
from walkergen.readers.walkers.marks import Marks

PAPER = templates.load("koumakis2016", "walkers", Design)
DISC = templates.load("polar-disc", "walkers", Design)
PRINTER = templates.load("prusa-mk3s", "printers", Printer)


def numbered_design(design, number, **keys):
    own = {f"marks.{key}": value for key, value in keys.items()}
    return design.variant(**{"marks.serial": number, **own})


@pytest.mark.parametrize(
    ("keys", "shown"),
    [
        ({}, "42"),
        ({"kind": "digits"}, "10-42"),
        ({"kind": "text", "text": "A"}, "A 42"),
        ({"kind": "notches", "line_mm": 0.35}, "### # # ## ## 42"),
    ],
)
def test_a_serial_number_is_next_to_the_mark_and_removes_plastic(keys, shown):
    own = numbered_design(PAPER, 42, **keys)
    assert own.mark == shown
    bare = own.variant(**{"marks.serial": None}) if keys else PAPER
    built, before = solids.build(own), solids.build(bare)
    assert modeller.count_bodies(built.walker) == 1
    assert solids.weigh(own, built).M < solids.weigh(bare, before).M
    other = solids.build(numbered_design(PAPER, 41, **keys))
    assert other.walker.vertices.shape != built.walker.vertices.shape or not np.array_equal(
        other.walker.vertices, built.walker.vertices
    )


def test_numbers_keep_below_notches():
    own = numbered_design(PAPER, 8, kind="notches", line_mm=0.35).marks
    lowest = min(one.bottom for one in marks.notches(own, [10.0], 10.0, 28.0, 3.0))
    strokes = marks.digit_strokes(own, 10.0, 3.0)
    assert max(one.top for one in strokes) <= lowest - own.line_mm + 1e-9
    assert min(one.bottom for one in strokes) >= -1.5 + own.line_mm - 1e-9


def test_a_body_in_plan_view_has_the_number_in_letters():
    own = numbered_design(DISC, 7)
    assert own.letters == own.mark == "7"
    assert modeller.count_bodies(solids.build(own).walker) == 1


@pytest.mark.parametrize(
    ("design", "keys", "told"),
    [
        (PAPER, {"kind": "notches"}, "below the notches"),
        (PAPER, {"kind": "digits", "line_mm": 0.5}, "leave out the serial numbers"),
        (
            PAPER.variant(tilt_deg=10.125, **{"body.length_mm": 20.0, "legs.contact_spacing_mm": 8.0}),
            {"kind": "digits"},
            "needs",
        ),
    ],
)
def test_no_room_is_one_line(design, keys, told):
    with pytest.raises(GeometryError, match=told) as caught:
        numbered_design(design, 99_999, **keys)
    assert len(str(caught.value).splitlines()) == 1


def test_numbers_count_over_all_copies_and_name_everything(tmp_path):
    members = PAPER.members([5.0, 10.0], ["flexible", "braced"])
    inputs = batch.PlateInputs(members, [2, 1, 1, 2], [PRINTER], "walker")
    rows = batch.make(PlateRequest(out=tmp_path, pictures=False, serial=98), inputs, lambda *_: None).places
    assert [row.copy for row in rows] == list(range(98, 104))
    assert [row.mark for row in rows] == [str(number) for number in range(98, 104)]
    assert all(row.item == f"{row.name}-{row.copy}" for row in rows)
    assert len({row.name for row in rows}) == 4
    found = threemf.read_3mf((tmp_path / "plates" / "plate_prusa-mk3s_1.3mf").read_bytes())
    assert [item.part_number for item in found.items] == [row.item for row in rows]
    assert len(set(found.names)) == 6  # a solid a number
    assert [row["part"] for row in rows_of(tmp_path / "weights.csv")] == [row.item for row in rows]
    sheet = (tmp_path / "plates" / "plate_prusa-mk3s.md").read_text(encoding="utf-8")
    assert "| 5 | `98` to `99`, `101` |" in sheet
    assert sheet.count("| `walker_t05.0_flexible_s0.40` |") == 2  # on the plate, and to weigh


def test_without_serial_numbers_nothing_changes():
    assert batch.number_copies(None, [PAPER], [3]) == ([PAPER], [3])
    assert names.reading_instructions(Marks()) == ""
