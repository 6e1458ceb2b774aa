"""Printers and plates: every copy once, on the bed, well apart, in the order given."""

import itertools
import math

import executed_lines
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from walkergen.core.errors import InputError, PlateError
from walkergen.core.files import config
from walkergen.core.printing import packing as plate
from walkergen.core.printing.packing import Part
from walkergen.core.printing.printers import Printer
from walkergen.files import templates

MK3S = templates.load("prusa-mk3s", "printers", Printer)
WALKER = (28.0, 12.0, 8.0)
ROUNDING_MM = 1e-6  # what rounding to whole micrometres may leave of a sum of floats, mm


def part(name: str, size: tuple[float, float, float] = WALKER, copies: int = 1) -> Part:
    return Part(name, *size, copies)


def boxes(one: plate.Plate, parts: list[Part]) -> list[tuple[float, float, float, float]]:
    return [(p.x, p.y, p.x + parts[p.part].width, p.y + parts[p.part].depth) for p in one.placements]


def check(
    plates: list[plate.Plate], parts: list[Part], printer: Printer, brim: float = 0.0, skirt: float = 0.0
) -> None:
    """Every copy once; none off the bed or closer than the gap, with its brim and skirt; all in the middle."""
    wanted = [(i, c) for i, one in enumerate(parts) for c in range(1, one.copies + 1)]
    assert sorted((p.part, p.copy) for one in plates for p in one.placements) == wanted
    low, gap = printer.margin_mm + skirt - ROUNDING_MM, printer.gap_mm - ROUNDING_MM
    right, back = printer.bed_width_mm - low, printer.bed_depth_mm - low
    for one in plates:
        placed = [(a - brim, b - brim, c + brim, d + brim) for a, b, c, d in boxes(one, parts)]
        assert placed
        assert all(a >= low and b >= low and c <= right and d <= back for a, b, c, d in placed)
        lefts, fronts, rights, backs = zip(*placed, strict=True)
        around = min(lefts) + max(rights), min(fronts) + max(backs)
        assert around == pytest.approx((printer.bed_width_mm, printer.bed_depth_mm), abs=0.004)
        for (a, b, c, d), (e, f, g, h) in itertools.combinations(placed, 2):
            assert e - c >= gap or a - g >= gap or f - d >= gap or b - h >= gap


@pytest.mark.parametrize("name", templates.names("printers"))
def test_shipped_printers_hold_a_walker(name: str) -> None:
    printer = templates.load(name, "printers", Printer)
    assert set(printer.model_fields_set) == set(Printer.model_fields)  # a template shows every key
    assert plate.capacity(part("walker"), printer) > 30


def test_a_bed_is_usable_at_the_extremes_of_its_ranges() -> None:
    tight = Printer(bed_width_mm=50.0, bed_depth_mm=50.0, height_mm=1.0, margin_mm=20.0)
    assert plate.capacity(part("small", (10.0, 10.0, 1.0)), tight) == 1
    assert plate.capacity(part("large", (10.0, 10.1, 1.0)), tight) == 0


def test_a_wrong_printer_is_refused_with_key_and_range() -> None:
    data = {**MK3S.model_dump(), "margin_mm": -1.0, "origin": "center"}
    with pytest.raises(InputError, match=r"margin_mm = -1\.0: must be a number >= 0") as caught:
        config.validate(data, Printer, "mine.toml")
    assert "must be one of 'corner', 'centre'" in str(caught.value)


length = st.floats(0.05, 60.0)
several_parts = st.lists(st.tuples(length, length, st.integers(1, 12)), min_size=1, max_size=6)


@settings(max_examples=40, deadline=None)
@given(several_parts, st.floats(0.0, 10.0), st.floats(0.0, 5.0), st.floats(80.0, 200.0))
def test_parts_keep_their_distance_and_stay_on_the_bed(
    sizes: list[tuple[float, float, int]], margin: float, gap: float, bed: float
) -> None:
    printer = MK3S.model_copy(update={"bed_width_mm": bed, "bed_depth_mm": 80.0, "margin_mm": margin, "gap_mm": gap})
    parts = [Part(f"p{i}", w, d, 5.0, copies) for i, (w, d, copies) in enumerate(sizes)]
    plates = plate.pack(parts, printer)
    check(plates, parts, printer)
    assert plates == plate.pack(list(parts), printer)


@settings(max_examples=25, deadline=None)
@given(st.floats(8.0, 90.0), st.floats(8.0, 90.0), st.floats(0.0, 6.0))
def test_copies_of_one_part_fill_the_grid(width: float, depth: float, gap: float) -> None:
    printer = MK3S.model_copy(update={"gap_mm": gap})
    one = Part("box", width, depth, 8.0, 1)
    count = plate.capacity(one, printer)
    full = plate.pack([one._replace(copies=count)], printer)
    assert len(full) == 1
    assert len(plate.pack([one._replace(copies=count + 1)], printer)) == 2


def test_walkers_on_a_prusa_bed_reach_the_ideal_count() -> None:
    ideal = math.floor((240.0 + 3.0) / (28.0 + 3.0)) * math.floor((200.0 + 3.0) / (12.0 + 3.0))
    assert plate.capacity(part("walker"), MK3S) == ideal == 91
    plates = plate.pack([part("walker", copies=1000)], MK3S)
    assert [len(one.placements) for one in plates] == [91] * 10 + [90]


def test_a_family_lies_in_rows_in_the_order_given() -> None:
    parts = [part(f"t{tilt}", (28.0, 12.0 - 0.03 * (3 * tilt % 50), 8.0), 7) for tilt in range(0, 50, 5)]
    (one,) = plate.pack(parts, MK3S)
    assert [p.part for p in one.placements] == sorted(p.part for p in one.placements)
    rows = [list(row) for _, row in itertools.groupby(one.placements, key=lambda p: p.y)]
    assert [[p.part for p in row] for row in rows] == [[tilt] * 7 for tilt in range(10)]
    assert [p.copy for p in rows[0]] == list(range(1, 8))
    # 7 x 28 mm and 6 gaps of 3 mm leave 36 mm of 250; ten rows leave 69.75 mm of 210.
    assert one.placements[0] == plate.Placement(0, 1, 18.0, 34.875)


def test_a_part_exactly_as_large_as_the_usable_bed_fits() -> None:
    parts = [part("slab", (0.1 + 0.2 + 239.7, 200.0, 210.0))]  # 240 but for the last digits
    assert plate.pack(parts, MK3S)[0].placements == (plate.Placement(0, 1, 5.0, 5.0),)


@pytest.mark.parametrize("size", [(240.01, 12, 8), (28, 200.01, 8), (28, 12, 210.01), (1e6,) * 3])
def test_a_part_too_large_for_the_printer_is_refused_with_sizes(size: tuple[float, float, float]) -> None:
    parts = [part("small"), part("large", size), part("also", (900.0, 1.0, 1.0))]
    with pytest.raises(PlateError) as caught:
        plate.pack(parts, MK3S)
    message = str(caught.value)
    assert message.startswith(f"large: {size[0]:.7g} x {size[1]:.7g} x {size[2]:.7g} mm")
    assert "prusa-mk3s. Its bed is 240 x 200 mm inside margins of 5 mm, and it prints 210 mm high" in message
    assert ". 1 more do not fit either. " in message
    assert len(message.splitlines()) == 1


def test_too_many_plates_are_refused_with_the_number_that_fits() -> None:
    parts = [part("walker", copies=200)]
    assert len(plate.pack(parts, MK3S, max_plates=3)) == 3
    with pytest.raises(PlateError, match=r"^200 parts need 3 beds .* max_plates=2 holds 182\."):
        plate.pack(parts, MK3S, max_plates=2)


@pytest.mark.parametrize("copies", [plate.MAX_ARRANGED_PARTS + 1, 10**15])
def test_too_many_parts_are_refused_immediately(copies: int) -> None:
    with pytest.raises(PlateError, match=rf"^{copies} parts: at most {plate.MAX_ARRANGED_PARTS}"):
        plate.pack([part("walker", copies=copies)], MK3S)


def test_no_parts_need_no_plate() -> None:
    assert plate.pack([], MK3S) == []


def test_a_thousand_parts_are_packed_in_one_pass() -> None:
    sizes = np.random.default_rng(5).uniform((20.0, 8.0), (35.0, 14.0), (1000, 2)).tolist()
    parts = [part(f"p{i}", (w, d, 8.0)) for i, (w, d) in enumerate(sizes)]
    half, whole = (executed_lines.lines(lambda count=count: plate.pack(parts[:count], MK3S)) for count in (500, 1000))
    assert whole < 2.1 * half  # no part is compared with those before it: 2.00 measured
    assert whole < 100 * len(parts)  # 42 measured
    plates = plate.pack(parts, MK3S)
    full = [sum((c - a + 3.0) * (d - b + 3.0) for a, b, c, d in boxes(p, parts)) for p in plates]
    # A row is as deep as its deepest part, 13.5 mm of parts that are 11 in the mean; and up to half
    # a part is free at its end: 0.77 measured.
    assert np.mean(full[:-1]) > 0.7 * 243.0 * 203.0


def test_parts_of_a_family_fill_the_bed_row_by_row() -> None:
    """Neighbours in the order of tilts are almost equally deep, so that rows waste little."""
    parts = [part(f"t{tilt}", (28.0, 10.5 - 0.04 * tilt, 8.0), 37) for tilt in range(0, 50, 5)]
    plates = plate.pack(parts, MK3S)
    order = [(p.part, p.copy) for one in plates for p in one.placements]
    assert order == sorted(order)
    for one in plates:
        places = [(p.y, p.x) for p in one.placements]
        assert places == sorted(places)
    mean = 7 * 203.0 / (10.5 - 0.04 * 22.5 + 3.0)  # if rows could be cut anywhere
    assert len(plates) == math.ceil(370 / (mean - 7))


@pytest.mark.parametrize(("brim", "distance", "loops"), [(0.0, 6.0, 2), (4.0, 6.0, 0), (3, 2, 1)])
def test_brims_and_skirts_stay_on_the_bed_and_apart(brim: float, distance: float, loops: int) -> None:
    printer = MK3S.model_copy(update={"brim_width_mm": brim, "skirt_distance_mm": distance, "skirt_loops": loops})
    one = part("walker", copies=1000)
    skirt = (loops + 0.5) * printer.line_width_mm + distance if loops else 0.0
    plates = plate.pack([one], printer)
    check(plates, [one], printer, brim, skirt)
    assert len(plates[0].placements) == plate.capacity(one, printer)


def test_a_brim_that_leaves_no_bed_is_refused() -> None:
    printer = Printer(bed_width_mm=50.0, bed_depth_mm=50.0, height_mm=50.0, brim_width_mm=30.0, gap_mm=0.0)
    assert plate.capacity(part("walker"), printer) == 0
    with pytest.raises(PlateError, match="does not fit"):
        plate.pack([part("walker")], printer)


def test_a_plate_holds_at_most_what_is_allowed() -> None:
    parts = [part("a", copies=25), part("b", copies=9)]
    plates = plate.pack(parts, MK3S, max_parts=10)
    assert [len(one.placements) for one in plates] == [10, 10, 10, 4]
    check(plates, parts, MK3S)
    with pytest.raises(PlateError, match=r"34 parts need 4 beds .* max_plates=3 holds 30\."):
        plate.pack(parts, MK3S, max_plates=3, max_parts=10)
