"""Figures of sweeps: the right kind for the keys, every point in sight, nothing by colour alone."""

import warnings

import numpy as np
import pytest
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.colors import to_rgb
from matplotlib.text import Text

from walkergen.files import figures as files
from walkergen.files import key_names
from walkergen.guests.sweep import figures, panels, scales
from walkergen.guests.sweep.figures import Columns

TILT, DRIVE, MU = "legs.tilt_deg", "scene.drive.peak_speed_mm_s", "scene.contact.friction"
FOOT = "legs.foot"


def columns(error=1.0, missing=(), doubtful=(), **keys):
    """Table of all combinations of values, the speed a sum that tells them apart."""
    names = {"tilt": TILT, "drive": DRIVE, "mu": MU, "foot": FOOT}
    grid = np.meshgrid(*(np.arange(len(values)) for values in keys.values()), indexing="ij")
    places = [one.ravel() for one in grid]
    speed = sum(10.0**power * place for power, place in enumerate(places)) + 1.0
    for row in missing:
        speed[row] = np.nan
    status = ["refused" if row in missing else "slow" if row in doubtful else "ok" for row in range(len(speed))]
    values = {
        names[key]: [values[place] for place in column]
        for (key, values), column in zip(keys.items(), places, strict=True)
    }
    return Columns(values, speed, speed - error, speed + error, status)


def drawn(table, title="a sweep"):
    """Figure of a table, laid out without a warning, and its panels."""
    found = figures.draw_figure(table, list(table.keys), title)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found.draw_without_rendering()
    return found, [axes for axes in found.axes if axes.get_label() != "<colorbar>"]


def said(found):
    """Texts of a figure's legends."""
    return [text.get_text() for legend in found.legends for text in legend.get_texts()]


def lines_of(axes):
    """Lines that join points, with their places."""
    return [line for line in axes.lines if line.get_linestyle() not in ("None", "none") and len(line.get_xdata()) > 2]


def marks_of(axes, marker):
    return [line for line in axes.lines if line.get_marker() == marker and line.get_linestyle() == "None"]


def test_one_key_is_a_line_with_its_bounds_as_bars():
    table = columns(tilt=[0, 5, 10, 30])
    found, (axes,) = drawn(table)
    (line,) = lines_of(axes)
    np.testing.assert_array_equal(line.get_xdata(), [0, 5, 10, 30])  # uneven steps stay uneven
    np.testing.assert_array_equal(line.get_ydata(), table.value)
    (bars,) = axes.containers
    ends = np.array([segment[:, 1] for segment in bars.lines[2][0].get_segments()])
    np.testing.assert_allclose(ends, np.transpose([table.low, table.high]))
    assert axes.get_xlabel() == "tilt of the legs (deg)"
    assert axes.get_ylabel() == "speed (mm/s), bounds of 95 %"
    assert found.get_suptitle() == "a sweep"
    assert not found.legends


def test_rows_in_any_order_give_the_same_line():
    table = columns(tilt=[0, 5, 10, 30])
    turned = Columns({TILT: table.keys[TILT][::-1]}, *(one[::-1] for one in table[1:]))
    lines = [lines_of(drawn(one)[1][0])[0] for one in (table, turned)]
    np.testing.assert_array_equal(lines[0].get_xydata(), lines[1].get_xydata())


def test_many_points_have_a_band():
    table = columns(tilt=list(range(100)))
    _, (axes,) = drawn(table)
    assert not axes.containers
    (band,) = axes.collections
    corners = {tuple(corner) for corner in band.get_paths()[0].vertices}
    assert {(50.0, table.low[50]), (50.0, table.high[50])} <= corners


def test_predictions_have_no_bars_and_claim_none():
    table = columns(error=np.nan, tilt=[0, 5, 10])
    _, (axes,) = drawn(table)
    assert axes.get_ylabel() == "speed (mm/s)"
    assert not axes.containers
    assert not axes.collections


def test_failed_and_doubtful_points_are_in_sight():
    table = columns(tilt=[0, 5, 10, 20, 40], missing=[1, 3], doubtful=[2])
    found, (axes,) = drawn(table)
    (crosses,) = marks_of(axes, "x")
    np.testing.assert_array_equal(crosses.get_xdata(), [5, 20])
    below = crosses.get_transform().transform(crosses.get_xydata())[:, 1]
    assert (below < axes.bbox.y0).all()  # on the axis they would read as speeds
    opened = [one for one in marks_of(axes, "o") if one.get_markerfacecolor() == "white"]
    np.testing.assert_array_equal(np.concatenate([one.get_xdata() for one in opened]), [10])
    assert said(found) == ["no speed: 2 of 5", "not ok: 1, see status"]
    (line,) = lines_of(axes)
    np.testing.assert_array_equal(np.isnan(line.get_ydata()), [False, True, False, True, False])


def test_every_point_lies_above_the_axis_s_range_and_every_series_is_in_the_legend():
    """The longest tilts and the last friction have no speed: they widen the axis, and the legend says so."""
    table = columns(tilt=[0, 5, 10, 80], mu=[0.1, 0.2, 0.3], missing=[2, 5, 8, 9, 10, 11])
    found, (axes,) = drawn(table)
    low, high = axes.get_xlim()
    marks = np.concatenate([one.get_xdata() for one in marks_of(axes, "x")])
    assert low < marks.min() < 80 == marks.max() < high
    assert said(found) == ["0.1", "0.2", "0.3: no speed", "no speed: 6 of 12"]
    inside = found.get_tightbbox(), found.bbox_inches
    assert inside[0].x0 >= inside[1].x0 - 0.01
    assert inside[0].x1 <= inside[1].x1 + 0.01
    assert inside[0].y0 >= inside[1].y0 - 0.01


def test_more_words_than_lines_lie_along_the_axis():
    found, (axes,) = drawn(columns(foot=[*"abcdefg"], tilt=[5, 10]))
    assert [tick.get_text() for tick in axes.get_xticklabels()] == [*"abcdefg"]
    assert said(found) == ["5 deg", "10 deg"]


def test_words_are_categories_that_no_line_joins():
    _, (axes,) = drawn(columns(foot=["flat", "square", "round"]))
    assert [tick.get_text() for tick in axes.get_xticklabels()] == ["flat", "square", "round"]
    assert not lines_of(axes)
    assert axes.get_xlabel() == "foot of the legs"


@pytest.mark.parametrize("order", [("tilt", "drive"), ("drive", "tilt")])
def test_few_values_of_one_key_are_lines_of_their_own(order):
    """As in the paper's figure 5: speed against the plate's, for four tilts."""
    values = {"tilt": [5, 10, 15, 20], "drive": list(range(10, 120, 10))}
    table = columns(**{key: values[key] for key in order})
    found, (axes,) = drawn(table)
    lines = lines_of(axes)
    assert len(lines) == 4
    for tilt, line in zip(values["tilt"], lines, strict=True):
        rows = np.array(table.keys[TILT]) == tilt
        np.testing.assert_array_equal(line.get_xdata(), np.array(table.keys[DRIVE])[rows])
        np.testing.assert_array_equal(line.get_ydata(), table.value[rows])
    assert axes.get_xlabel() == "peak speed of the plate (mm/s)"
    assert found.legends[0].get_title().get_text() == "tilt of the legs"
    assert said(found) == ["5 deg", "10 deg", "15 deg", "20 deg"]
    handles = found.legends[0].legend_handles
    for look in ("get_linestyle", "get_marker", "get_color"):
        assert len({getattr(one, look)() for one in handles}) == 4


def test_two_keys_are_a_map_with_labelled_contours():
    tilts, frictions = [0, 5, 10, 20, 40, 45], [0.1, 0.2, 0.3, 0.5, 0.6, 0.7]
    table = columns(tilt=tilts, mu=frictions)
    found, (axes,) = drawn(table)
    (mesh,) = [one for one in axes.collections if isinstance(one, QuadMesh)]
    np.testing.assert_array_equal(mesh.get_array(), table.value.reshape(6, 6).T)
    across, up = mesh.get_coordinates()[0, :, 0], mesh.get_coordinates()[:, 0, 1]
    np.testing.assert_allclose(across, [-2.5, 2.5, 7.5, 15, 30, 42.5, 47.5])
    np.testing.assert_allclose(up, [0.05, 0.15, 0.25, 0.4, 0.55, 0.65, 0.75])
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("tilt of the legs (deg)", "friction")
    labels = [float(text.get_text()) for text in axes.texts]
    assert labels == sorted(set(labels))
    assert 1 <= len(labels) <= 8
    assert found.axes[-1].get_ylabel() == "speed (mm/s)"
    lightness = [np.dot(mesh.cmap(share)[:3], (0.299, 0.587, 0.114)) for share in (0.0, 0.5, 1.0)]
    assert lightness == sorted(lightness)  # in grey it says the same


def test_a_map_hatches_what_failed_and_leaves_out_what_is_not_there():
    table = columns(tilt=list(range(6)), mu=[0.1 * step for step in range(1, 8)], missing=[0, 9], doubtful=[20])
    inside = np.arange(42) < 36  # as when it was killed
    table = Columns(
        {key: np.array(values)[inside].tolist() for key, values in table.keys.items()},
        table.value[inside],
        table.low[inside],
        table.high[inside],
        table.status[:36],
    )
    found, (axes,) = drawn(table)
    (mesh,) = [one for one in axes.collections if isinstance(one, QuadMesh)]
    assert np.ma.getmaskarray(mesh.get_array()).sum() == 6 + 2
    (hatched,) = [one for one in axes.collections if isinstance(one, PolyCollection) and one.get_hatch()]
    centres = [path.vertices[:4].mean(axis=0) for path in hatched.get_paths()]
    np.testing.assert_allclose(centres, [[0, 0.1], [1, 0.3]])
    (rings,) = marks_of(axes, "o")
    np.testing.assert_allclose(rings.get_xydata(), [[2, 0.7]])
    assert said(found) == ["no speed: 2 of 36", "not ok: 1, see status"]


def test_three_keys_are_small_multiples_of_maps_with_one_scale_of_colours():
    table = columns(tilt=list(range(7)), mu=[0.1, 0.2, 0.3], drive=list(range(10, 80, 10)))
    found, panels_ = drawn(table)
    assert [axes.get_title() for axes in panels_] == [f"friction {friction}" for friction in (0.1, 0.2, 0.3)]
    meshes = [one for axes in panels_ for one in axes.collections if isinstance(one, QuadMesh)]
    assert len(meshes) == 3
    assert {mesh.get_clim() for mesh in meshes} == {(table.value.min(), table.value.max())}
    for number, mesh in enumerate(meshes):
        rows = np.array(table.keys[MU]) == (0.1, 0.2, 0.3)[number]
        np.testing.assert_array_equal(mesh.get_array(), table.value[rows].reshape(7, 7).T)
    assert len(found.axes) == 4


def test_three_keys_with_few_values_are_small_multiples_of_lines():
    table = columns(tilt=list(range(7)), mu=[0.1, 0.2, 0.3], foot=["flat", "square"])
    found, panels_ = drawn(table)
    assert [axes.get_title() for axes in panels_] == ["foot of the legs flat", "foot of the legs square"]
    assert [len(lines_of(axes)) for axes in panels_] == [3, 3]
    assert said(found) == ["0.1", "0.2", "0.3"]
    assert len({axes.get_ylim() for axes in panels_}) == 1


def test_more_panels_than_a_page_holds_are_counted():
    frictions = [round(0.05 * step, 2) for step in range(1, 16)]
    table = columns(tilt=list(range(16)), mu=frictions, drive=list(range(10, 180, 10)))
    found, panels_ = drawn(table)
    assert len(panels_) == figures.MAX_PANELS
    assert panels_[0].get_title() == "friction 0.05"
    assert panels_[-1].get_title() == "friction 0.75"
    title = " ".join(found.get_suptitle().split())
    assert title == "a sweep; 3 of 15 values of scene.contact.friction left out"


def cloud(count, *names, missing=(), doubtful=()):
    rng = np.random.default_rng(1)
    speed = rng.uniform(0, 50, count)
    speed[list(missing)] = np.nan
    status = ["slow" if row in doubtful else "ok" for row in range(count)]
    keys = {name: rng.uniform(1, 45, count).tolist() for name in names}
    return Columns(keys, speed, speed - 1, speed + 1, status)


def test_samples_of_two_keys_are_coloured_by_their_speed():
    table = cloud(40, TILT, MU, missing=[3], doubtful=[5, 6])
    found, (axes,) = drawn(table)
    good, rings = axes.collections
    kept = np.ones(40, dtype=bool)
    kept[[3, 5, 6]] = False
    np.testing.assert_allclose(good.get_offsets()[:, 0], np.array(table.keys[TILT])[kept])
    np.testing.assert_allclose(good.get_array(), table.value[kept])
    assert rings.get_offsets().shape == (2, 2)
    assert len(rings.get_facecolor()) == 0
    (crosses,) = marks_of(axes, "x")
    assert crosses.get_xydata().tolist() == [[table.keys[TILT][3], table.keys[MU][3]]]
    assert said(found) == ["no speed: 1 of 40", "not ok: 2, see status"]


def test_samples_of_more_keys_are_a_panel_each():
    table = cloud(40, TILT, MU, DRIVE, "legs.length_mm", missing=[3], doubtful=[5])
    _, panels_ = drawn(table)
    assert [axes.get_xlabel() for axes in panels_] == [
        "tilt of the legs (deg)",
        "friction",
        "peak speed of the plate (mm/s)",
        "length of the legs (mm)",
    ]
    for axes in panels_:
        assert not lines_of(axes)
        assert sum(len(one.get_xdata()) for one in marks_of(axes, "o")) == 39


def test_bounds_that_nobody_could_see_are_neither_drawn_nor_claimed():
    for count, label in ((500, "speed (mm/s), bounds of 95 %"), (5000, "speed (mm/s)")):
        _, (axes, *_) = drawn(cloud(count, TILT, MU, DRIVE))
        assert axes.get_ylabel() == label
        assert bool(axes.containers) == (count == 500)


def test_a_key_with_one_value_is_left_out():
    _, (axes,) = drawn(columns(tilt=[5], mu=[0.1, 0.2, 0.3]))
    assert axes.get_xlabel() == "friction"


@pytest.mark.parametrize(
    ("values", "scale"),
    [
        ([1, 3, 10, 30, 100], "log"),
        ([1, 2, 5, 10], "linear"),
        ([0, 1, 10, 100], "linear"),
        ([-1, 10, 100], "linear"),
        (list(range(1, 101)), "linear"),
    ],
)
def test_an_axis_is_logarithmic_where_its_values_are(values, scale):
    _, (axes,) = drawn(columns(tilt=values))
    assert axes.get_xscale() == scale


def test_cells_of_a_logarithmic_axis_meet_half_way():
    scale = scales.make_scale("a", [1, 10, 100, 1000])
    np.testing.assert_allclose(scales.cell_edges(scale), 10 ** np.array([-0.5, 0.5, 1.5, 2.5, 3.5]))


@pytest.mark.parametrize(
    ("key", "label"),
    [
        ("legs.tilt_deg", "tilt of the legs (deg)"),
        ("scene.drive.gamma", "peak acceleration of the plate (g)"),
        ("scene.drive.peak_speed_mm_s", "peak speed of the plate (mm/s)"),
        ("legs[2].flexible_thickness_mm", "flexible thickness of leg 2 (mm)"),
        ("material.density_g_cm3", "density of the material (g/cm³)"),
        ("material.youngs_modulus_gpa", "Young's modulus of the material (GPa)"),
        ("scene.run.discard_seconds", "discarded time (s)"),
        ("scene.run.seconds", "measured time (s)"),
        ("scene.run.step_us", "step (µs)"),
        ("weighed.body_mass_g", "body mass (g)"),
    ],
)
def test_axes_are_named_in_words_with_units(key, label):
    assert key_names.format_key(key) == label


@pytest.mark.parametrize("count", [1, 2, 3])
def test_all_letters_can_be_read_at_the_width_of_a_column(count):
    keys = {"tilt": list(range(7)), "mu": [0.1 * step for step in range(1, 8)], "foot": ["flat", "square"]}
    table = columns(**dict(list(keys.items())[:count]), missing=[3], doubtful=[5])
    found, _ = drawn(table, "a long title of a sweep " * 8)
    shown = [one for one in found.findobj(Text) if one.get_text() and one.get_visible()]
    assert min(one.get_fontsize() for one in shown) >= 7
    assert found.get_figwidth() == pytest.approx(86 / 25.4)
    box = found.get_tightbbox()
    assert box.width <= found.get_figwidth() + 0.1


def test_the_colours_of_lines_differ_in_grey_or_by_their_dashes():
    for number, (colour, dash, marker) in enumerate(panels.LINE_STYLES):
        for other, other_dash, other_marker in panels.LINE_STYLES[:number]:
            assert dash != other_dash
            assert marker != other_marker
            assert to_rgb(colour) != to_rgb(other)


def test_equal_tables_give_equal_bytes():
    table = columns(tilt=list(range(6)), mu=[0.1 * step for step in range(1, 8)], missing=[4])
    pngs = [files.png(drawn(table)[0]) for _ in range(2)]
    assert pngs[0] == pngs[1]
    assert files.pdf(drawn(table)[0]) == files.pdf(drawn(table)[0])
