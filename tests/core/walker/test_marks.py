"""Marks: every engraving leaves one closed body, exact to the last digit and never ambiguous."""

import itertools

import mesh_checks
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from walkergen.core.errors import GeometryError
from walkergen.core.files import config
from walkergen.core.scene import Scene
from walkergen.core.theory import prediction
from walkergen.core.walker import mass, solids
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.readers.walkers import marks

PAPER = templates.load("koumakis2016", "walkers", Design)
KINDS = ("notches", "digits")


def marked_design(kind: str, **changes) -> Design:
    data = PAPER.model_dump()
    data["marks"] = {"kind": kind, **changes}
    return Design.model_validate(data)


def moments(rectangles) -> np.ndarray:
    """Area, first moments and polar second moment of a union of rectangles, cell by cell."""
    xs = sorted({x for r in rectangles for x in (r.left, r.right)})
    ys = sorted({y for r in rectangles for y in (r.bottom, r.top)})
    total = np.zeros(4)
    for (x0, x1), (y0, y1) in itertools.product(itertools.pairwise(xs), itertools.pairwise(ys)):
        x, y, area = 0.5 * (x0 + x1), 0.5 * (y0 + y1), (x1 - x0) * (y1 - y0)
        if any(r.left < x < r.right and r.bottom < y < r.top for r in rectangles):
            polar = x * x + y * y + ((x1 - x0) ** 2 + (y1 - y0) ** 2) / 12.0
            total += area * np.array([1.0, x, y, polar])
    return total


def mark_rectangles(design: Design):
    """The marks' rectangles and how deep they go along z."""
    body = design.body
    if design.marks.kind == "digits":
        strokes = marks.digit_strokes(design.marks, design.tilt_deg, body.thickness_mm)
        return strokes, design.marks.depth_mm
    sizes = body.length_mm, body.thickness_mm
    grooves = marks.notches(design.marks, design.family.tilt_deg, design.tilt_deg, *sizes)
    return grooves, body.depth_mm


@pytest.mark.parametrize("kind", KINDS)
def test_marks_are_counted_in_mass_and_inertia(kind):
    """Against closed form: the block's moments less those of the rectangles cut out of it."""
    design, density = marked_design(kind), 1.24e-3
    for member in design.members(kinds=["flexible"]):
        body = member.body
        x, y = 0.5 * body.length_mm, 0.5 * body.thickness_mm
        block = body.depth_mm * moments([marks.Rectangle(-x, -y, x, y)])
        rectangles, deep = mark_rectangles(member)
        volume, first_x, first_y, polar = block - deep * moments(rectangles)
        inertia = polar - (first_x**2 + first_y**2) / volume
        found = solids.mass_of(member)
        assert found.M == pytest.approx(density * volume, rel=1e-13)
        assert found.J == pytest.approx(density * inertia, rel=1e-12)
        anchor = member.limbs[0].anchor[0] - first_x / volume
        assert found.legs[0].anchor[0] == pytest.approx(anchor, abs=1e-12)
        assert volume < (1.0 - 1e-3) * block[0]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["koumakis2016", "maker-large"])
def test_marked_families_are_sound(kind, name):
    design = templates.load(name, "walkers", Design)
    design = design.model_copy(update={"marks": marks.Marks(kind=kind)})
    for member in design.members():
        mesh_checks.check(member)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(
    kind=st.sampled_from(KINDS),
    body=st.tuples(st.floats(20.0, 60.0), st.floats(0.5, 30.0), st.floats(1.0, 10.0)),
    line=st.floats(0.05, 1.5),
    depth=st.floats(0.01, 3.0),
    tilt=st.sampled_from([0.0, 1e-12, -7.5, 10.0, 12.3456, 88.0 / 3.0]),
    legs=st.sampled_from(["flexible", "braced"]),
    count=st.integers(1, 100),
)
def test_any_marked_design_is_sound_or_refused(kind, body, line, depth, tilt, legs, count):
    data = {
        "body": dict(zip(("length_mm", "depth_mm", "thickness_mm"), body, strict=True)),
        "legs": {"tilt_deg": tilt, "kind": legs},
        "marks": {"kind": kind, "line_mm": line, "depth_mm": depth},
        "family": {"tilt_deg": [*(0.1 * k + 40.0 for k in range(count)), tilt]},
    }
    try:
        design = Design.model_validate(data)
    except GeometryError:
        return
    built = mesh_checks.check(design)
    plain = mass.weigh(solids.build(design.unmarked).body, 1.0).volume
    rectangles, deep = mark_rectangles(design)
    removed = deep * moments(rectangles)[0]
    assert mass.weigh(built.body, 1.0).volume == pytest.approx(plain - removed, rel=1e-12)


def test_every_tilt_of_a_family_has_its_own_mark():
    for kind in KINDS:
        words = [member.mark for member in marked_design(kind).members(kinds=["flexible"])]
        assert len(set(words)) == len(words) == 10
    assert words[:4] == ["0", "5", "10", "15"]
    assert marked_design("notches").mark == "### # # ## ##"  # the third of ten: 0011 in base two


def test_notches_mean_the_same_for_any_requested_tilts():
    design = marked_design("notches")
    (alone,) = design.members([35.0], ["flexible"])
    assert alone.mark == design.members()[7].mark == "### ## # # #"
    with pytest.raises(GeometryError, match=r"family\.tilt_deg, which lack 12: add it"):
        design.members([12.0])


def test_the_start_is_widest_and_nearest_the_front_so_that_no_mirror_image_reads_the_same():
    for member in marked_design("notches").members(kinds=["flexible"]):
        grooves, _ = mark_rectangles(member)
        widths = [round((g.right - g.left) / 0.8) for g in grooves]
        assert widths[0] == marks.START_NOTCH > max(widths[1:])
        assert grooves[0].right == pytest.approx(14.0 - 0.8)
        free = [before.left - after.right for before, after in itertools.pairwise(grooves)]
        assert free == pytest.approx([0.8] * len(free))


def test_strokes_and_gaps_of_digits_are_at_least_a_line():
    for member in marked_design("digits").members(kinds=["flexible"]):
        strokes, _ = mark_rectangles(member)
        ys = sorted({y for r in strokes for y in (r.bottom, r.top)} | {-1.5, 1.5})
        assert min(np.diff(ys)) >= 0.4 - 1e-12
        assert min(min(r.right - r.left, r.top - r.bottom) for r in strokes) >= 0.4 - 1e-12


def test_digits_show_every_digit_of_the_tilt():
    told = [marks.format_tilt(value) for value in (10.0, -7.5, -0.0, 1e-12, 12.25)]
    assert told == ["10", "-7.5", "0", "0.000000000001", "12.25"]


def test_the_limits_that_a_refusal_names_are_buildable():
    for kind, line in (("digits", 3.0 / 7.0 - 1e-9), ("notches", 28.0 / 34.0 - 1e-9)):
        for member in marked_design(kind, line_mm=line, depth_mm=1.0).members():
            mesh_checks.check(member)


def test_a_refusal_names_the_line_of_the_file(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text('[marks]\nkind = "digits"\nline_mm = 0.5\n[legs]\ntilt_deg = 80\n')
    with pytest.raises(GeometryError) as caught:
        config.read_section(path, Design)
    lines = str(caught.value).splitlines()
    assert any(line.startswith(f"{path}:3: marks.line_mm = 0.5") for line in lines)
    assert any(line.startswith(f"{path}:5: legs.tilt_deg = 80") for line in lines)


def test_the_curve_between_a_family_s_tilts_is_that_of_unmarked_walkers():
    """Notches number the family's tilts; the figure's curve has others, 181 of them."""
    scene = templates.load("lane-90hz", "scenes", Scene)
    marked_curve, plain = (
        prediction.predict_curve(design, scene, "coulomb", 5.0, 15.0) for design in (marked_design("notches"), PAPER)
    )
    np.testing.assert_array_equal(marked_curve.speed, plain.speed)
