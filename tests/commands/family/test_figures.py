"""Figures: sizes of a journal, letters that can be read, lines told apart without colours."""

from itertools import combinations, pairwise

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text
from synthetic_tracks import film

from walkergen.analysis import motion
from walkergen.analysis.speeds import Measured as Speeds
from walkergen.analysis.tracks import Track
from walkergen.commands.accuracy.choice import RUN_COUNTS, STARTUP_S, Candidate
from walkergen.commands.accuracy.figures import FigureData, Point, choice_figure, compute_front
from walkergen.commands.family import chart_data
from walkergen.commands.family import figures as family
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.theory.prediction import Curve, Prediction, make_speed
from walkergen.files import figures
from walkergen.guests.track.analyse import report as analysis
from walkergen.points.members import Simulated
from walkergen.points.track_figure import draw_tracks

TITLE = "koumakis2016: 90 Hz, 1.8 g, restitution 0.8 (poisson), friction 0.25"
MM = 25.4


def row(tilt, legs, speed):
    bounds = tuple(speed + off for off in (-20.0, -10.0, 20.0, 40.0))
    values = dict.fromkeys(Prediction._fields)
    values |= {"tilt_deg": tilt, "legs": legs, "speed": make_speed("speed", speed, 15.0, bounds)}
    return Prediction(**values)


def curve(speed):
    tilt = np.linspace(0.0, 45.0, 91)
    bounds = np.array([speed + off + 0.0 * tilt for off in (-20.0, -10.0, 20.0, 40.0)])
    return Curve(tilt, speed + 0.0 * tilt, bounds, speed + 0.0 * tilt, speed - 3.0 * tilt, tilt < 14.0)


ROWS = [row(tilt, legs, 40.0) for legs in ("flexible", "braced") for tilt in (5.0, 10.0)]
SIMULATED = [Simulated(Quantity("speed", "mm_s", 42.0, 2.0, ends=(38.0, 40.0, 44.0, 46.0)), "8 ok", "agree")] * 4
MEASURED = Speeds(
    np.array([10.0, 10.0]),
    ["flexible", "braced"],
    np.array([58.0, 1.0]),
    np.array([4.0, 0.0]),
    np.array([31.0, 31.0]),
    "",
)
SHOWN = chart_data.ChartData({"flexible": curve(40.0), "braced": curve(0.0)}, MEASURED, (10.0, 60.0))


def speed_figure(rows=ROWS, shown=SHOWN, simulated=SIMULATED, named=False):
    return family.speed_figure(rows, shown, TITLE, simulated, named)


def speed_of_one():
    return speed_figure([ROWS[1]], chart_data.ChartData({}), SIMULATED[:1])


BIASES = {1.2: 0.01, 2.3: 0.028, 4.6: 0.031, 5.8: 0.11, 7.4: 0.079}
"""Bounds of biases in space, as shares, by step."""

CURVES = [Candidate(step, bias, 1e-3, 0.2 / step, 1.0 / RUN_COUNTS[0]) for step, bias in BIASES.items()]
POINTS = [Point(0.05, 1.5, "5 %: 1.5 s"), Point(0.02, 20.0, "2 %: 20 s")]
FLOOR = 0.015


def choices():
    return choice_figure(FigureData(TITLE, CURVES, POINTS, ["1 % (no setting is known)"], FLOOR, 2))


@pytest.fixture(scope="module")
def tracks():
    return film(1, 3, 5.0)


def figures_of(tracks, title):
    """Figures of the motion of tracks by their names."""
    made = analysis.make_report(tracks, motion.analyse(tracks), title)
    return {name: draw() for name, draw in made.figures.items()}


@pytest.fixture(scope="module")
def drawn(tracks):
    made = {
        "speed": speed_figure(),
        "speed of one": speed_of_one(),
        "named": speed_figure(ROWS[::2], chart_data.ChartData({}), SIMULATED[:2], named=True),
        "choice": choices(),
        **figures_of(tracks, "films/a_film_with_a_long_name_of_2026.csv"),
    }
    with figures.style():
        for figure in made.values():
            figure.draw_without_rendering()
    return made


def texts(figure):
    return [text for text in figure.findobj(Text) if text.get_visible() and text.get_text()]


@pytest.mark.slow
def test_figures_have_a_journals_width_and_letters_of_seven_points_or_more(drawn):
    for name, figure in drawn.items():
        assert round(MM * figure.get_figwidth()) in (86, 178), name
        sizes = {text.get_text(): text.get_fontsize() for text in texts(figure)}
        small = {told: size for told, size in sizes.items() if size < figures.MIN_FONT_PT}
        assert not small, name


def test_every_figure_has_a_title_inside_it_and_its_pdf_bears_it(drawn):
    for name, figure in drawn.items():
        title = figures.figure_title(figure)
        assert title, name
        (shown,) = [one for one in texts(figure) if " ".join(one.get_text().split()) == title]
        box = shown.get_window_extent()
        assert box.x0 >= 0.0, name
        assert box.x1 <= figure.bbox.x1, name
    data = figures.pdf(drawn["speed of one"])
    assert b"/Title (koumakis2016: 90 Hz" in data
    assert b"/Type3" not in data  # journals refuse its letters
    assert b"/FontFile2" in data
    assert data == figures.pdf(speed_of_one())


def test_series_differ_in_line_and_marker_and_not_only_in_colour():
    for one, other in combinations(figures.SERIES, 2):
        assert one[1] != other[1]
        assert one[2] != other[2]
    for one, other in combinations(figures.LEG_STYLES.values(), 2):
        assert one[1:] != other[1:]
    for colour, *_ in figures.SERIES:  # dark enough on white
        assert to_rgb(colour) @ np.array([0.299, 0.587, 0.114]) < 0.66


def test_the_front_is_the_least_error_of_all_curves_for_a_time(drawn):
    least = compute_front(CURVES, 60.0)
    for curve in CURVES:
        assert np.all(least.total <= np.hypot(curve.scatter_error(least.cpu_s), curve.bias) * (1 + 1e-12))
    assert np.all(np.diff(least.total) <= 1e-12)  # more time is never worse
    axes = drawn["choice"].axes[0]
    (line,) = [line for line in axes.get_lines() if line.get_linestyle() == "-"]
    assert line.get_label() == "least error for the time"
    waits, errors = line.get_data()
    for curve in CURVES:  # of eight runs on two cores, every fourth of the time is waited for
        errors_then = np.hypot(curve.scatter_error(2.0 * (waits - STARTUP_S)), curve.bias)
        assert np.all(errors <= errors_then * (1 + 1e-9))


def test_dots_lie_where_their_labels_say_and_no_label_covers_the_curve(drawn):
    axes = drawn["choice"].axes[0]
    dots = [line for line in axes.get_lines() if line.get_marker() == "o"]
    places = [(dot.get_xdata()[0], dot.get_ydata()[0]) for dot in dots]
    assert places == [(point.wait_s, point.error) for point in POINTS]
    (line,) = [line for line in axes.get_lines() if line.get_linestyle() == "-"]
    path = axes.transData.transform(line.get_xydata())
    share = np.linspace(0.0, 1.0, 9999)
    path = np.transpose([np.interp(share, np.linspace(0.0, 1.0, len(path)), along) for along in path.T])
    for text in axes.texts:
        assert not text.get_window_extent().count_contains(path), text.get_text()


def test_nothing_is_drawn_below_what_the_reference_is_known_to(drawn):
    axes = drawn["choice"].axes[0]
    for line in axes.get_lines():
        assert not np.any(np.asarray(line.get_ydata(), dtype=float) < FLOOR * (1 - 1e-9))
    told = [text.get_text() for text in axes.texts]
    assert "below" not in told
    assert {"5 %: 1.5 s", "2 %: 20 s"} <= set(told)
    assert any("1.5 %; no dot for 1 % (no setting is known)" in text for text in told)
    low, high = axes.get_xlim()
    assert 0.5 < low < STARTUP_S  # no command is faster
    assert 20.0 < high < 200.0


def test_ticks_of_a_logarithmic_axis_are_plain_and_do_not_collide():
    for low, high in ((0.011, 0.05), (2.6, 5.3), (3e-5, 4.0), (0.4, 60.0), (1e-9, 1e9)):
        figure = Figure(figsize=(figures.COLUMN_INCHES, 2.0), layout="constrained")
        with figures.style():
            axes = figure.subplots()
            axes.set_xscale("log")
            axes.set_xlim(low, high)
            figures.set_log_ticks(axes.xaxis)
            figure.draw_without_rendering()
            labels = [tick for tick in axes.get_xticklabels() if tick.get_text()]
            boxes = [one.get_window_extent() for one in labels if low <= one.get_position()[0] <= high]
        assert len(boxes) >= 2, (low, high)
        assert all(a.x1 < b.x0 for a, b in pairwise(boxes)), (low, high)
    assert [figures._format_power(value) for value in (0.02, 1000.0, 1e-5, 2e6)] == [
        "0.02",
        "1000",
        "$10^{-5}$",
        r"$2 \times 10^{6}$",
    ]


def test_walkers_that_do_not_turn_have_neither_correlation_nor_tracks_from_above():
    turning, straight = film(1, 3, 5.0), film(1, 3, 5.0)
    line = [Track(one.particle, one.position[:, :1] * [1.0, 1e-3], 1e-3 * one.heading) for one in straight.tracks]
    straight = straight._replace(tracks=tuple(line))
    for tracks, names in ((turning, {"correlation"}), (straight, set())):
        found = figures_of(tracks, "title")
        assert {"correlation"} & found.keys() == names
        label = found["trajectories"].axes[0].get_xlabel()
        assert label == ("x (mm); arrows: headings" if names else "time (s)")


def test_arrows_point_where_the_tracks_head(tracks, drawn):
    arrows = [one for one in drawn["trajectories"].axes[0].collections if hasattr(one, "U")]
    assert len(arrows) == len(tracks.tracks)
    for track, arrow in zip(tracks.tracks, arrows, strict=True):
        for place, U, V in zip(arrow.XY, arrow.U, arrow.V, strict=True):
            at = np.nanargmin(np.abs(track.position - place).sum(axis=1))
            assert (U, V) == pytest.approx((np.cos(track.heading[at]), np.sin(track.heading[at])))
    headless = film(2, 2, 1.0, headed=False)
    axes = draw_tracks(headless, "without").axes[0]
    assert not [one for one in axes.collections if hasattr(one, "U")]


def test_slopes_are_told_in_words(drawn):
    legend = drawn["msd"].axes[0].get_legend().get_texts()
    told = [text.get_text() for text in legend]
    assert any(name.startswith("slope 2: v²t², v = 30 mm/s") for name in told)
    assert any(name.startswith("slope 1: 4Dt, D = ") for name in told)


def test_what_speed_png_shows_is_in_speed_csv():
    lines = chart_data.table(SHOWN).csv().splitlines()
    assert lines[0].split(",") == list(chart_data.KEYS)
    kinds = [line.split(",")[0] for line in lines[1:]]
    assert kinds == ["predicted"] * 182 + ["measured"] * 2 + ["paper"]
    assert lines[1] == "predicted,flexible,0.0,40.0,30.0,60.0,20.0,80.0,40.0,yes"
    assert lines[-3].startswith("measured,flexible,10.0,58.0,54.0,62.0,50.16,65.84")
    assert lines[-1] == "paper,flexible,10.0,60.0,,,,,,"


@pytest.mark.parametrize("kinds", [("flexible", "braced"), ("braced", "flexible"), ("braced",), ()])
def test_one_dashed_line_is_the_theory_of_flexible_legs_if_any(kinds):
    shown = SHOWN._replace(curves={kind: SHOWN.curves[kind] for kind in kinds})
    figure = speed_figure(shown=shown)
    lines = [line for line in figure.axes[0].get_lines() if line.get_color() == figures.INK]
    assert [line.get_linestyle() for line in lines] == ["--"] * bool(kinds)
    drawn_kind = "flexible" if "flexible" in kinds else "braced"
    for line in lines:
        assert line.get_ydata().tolist() == SHOWN.curves[drawn_kind].theory.tolist()
    assert [text.get_text() for text in texts(figure)].count(family.THEORY_LABEL) == bool(kinds)


def test_measured_speeds_stand_at_the_walker_where_no_tilt_is_common():
    rows = [row(10.0, "flexible", 40.0)]
    axes = speed_figure(rows, SHOWN._replace(curves={}), (), named=True).axes[0]
    crosses = [line for line in axes.get_lines() if line.get_marker() in ("x", "+")]
    assert [line.get_xdata().tolist() for line in crosses] == [[0.0]]
    found = chart_data.assign_member_tilts(MEASURED, {"braced": 3.0})
    assert (found.tilt.tolist(), found.legs, found.speed.tolist()) == ([3.0], ["braced"], [1.0])
    assert found.se.tolist() == [0.0]


def test_a_star_and_a_measured_point_hide_no_member():
    axes = speed_figure().axes[0]
    star = next(line for line in axes.get_lines() if line.get_marker() == "*")
    members = [line for line in axes.get_lines() if line.get_marker() in ("o", "s")]
    assert star.get_markerfacecolor() == "white"
    assert star.get_zorder() < max(line.get_zorder() for line in members)


def test_no_settings_of_a_person_come_into_a_picture():
    """As those of a matplotlibrc in the current folder."""

    def drawn():
        figure, axes = figures.new_axes("title")
        with figures.style():
            axes.plot([0.0, 1.0])
        return figures.png(figure)

    plain = drawn()
    with matplotlib.rc_context({"axes.facecolor": "red", "savefig.bbox": "tight"}):
        assert drawn() == plain
