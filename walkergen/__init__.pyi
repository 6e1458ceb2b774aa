# Made of the requests by `python -m walkergen.api.functions`
import os
from collections.abc import Iterable, Mapping
from typing import Any, Literal

from walkergen.api.loading import load, templates
from walkergen.commands.check.make import CheckReport
from walkergen.commands.check.weigh_report import WeighReport
from walkergen.commands.family.report import FamilyReport
from walkergen.commands.predict.make import PredictReport
from walkergen.commands.simulate.report import SimulationReport
from walkergen.core.errors import WalkergenError
from walkergen.core.files.progress import Progress
from walkergen.core.printing.printers import Printer
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import Kind
from walkergen.files.report import Report
from walkergen.guests.crowd.cards.card import Card
from walkergen.guests.lab.fit.report import FitReport
from walkergen.guests.sweep.report import SweepReport
from walkergen.guests.track.analyse.report import AnalysisReport
from walkergen.guests.track.film.report import TrackReport

__version__: str

Name = str | os.PathLike[str]
Walker = Design | Name
Ground = Scene | Name
Machine = Printer | Name

__all__ = [
    "Design",
    "Printer",
    "Scene",
    "WalkergenError",
    "__version__",
    "accuracy",
    "analyse",
    "calibrate",
    "check",
    "crowd",
    "explain",
    "export",
    "family",
    "fit",
    "load",
    "movie",
    "plate",
    "predict",
    "selftest",
    "simulate",
    "sweep",
    "templates",
    "track",
]

def family(
    design: Walker = "koumakis2016",
    out: Name | None = None,
    *,
    tilt: float | Iterable[float] | str | None = None,
    legs: Kind | Iterable[Kind] | None = None,
    scene: Ground | None = None,
    restitution: float | None = None,
    friction: float | None = None,
    gamma: float | None = None,
    frequency: float | None = None,
    mode: Literal["coulomb", "paper"] = "coulomb",
    printer: Machine = "prusa-mk3s",
    text: str | None = None,
    mirror: bool | None = None,
    set: Mapping[str, Any] = {},
    copies: int | Mapping[float, int] | str = 1,
    max_parts: int = 5000,
    prusaslicer: bool = False,
    weights: Name | None = None,
    model: Literal["best", "known", "theory"] = "best",
    simulate: bool = False,
    seconds: float | None = None,
    runs: int | None = None,
    measured: Name | None = None,
    page: bool = False,
    pictures: bool = True,
    strict: bool = False,
    progress: Progress | None = None,
) -> FamilyReport:
    """Make a family of walkers: STL files, plates, predicted speeds, pictures.

    With --page also one self-contained HTML page that opens offline.

    Example: `wg.family("koumakis2016", "out/mine", tilt="5:20:5", legs="flexible")`
    """

def export(
    design: Walker = "koumakis2016",
    out: Name | None = None,
    *,
    tilt: float | Iterable[float] | str | None = None,
    legs: Kind | Iterable[Kind] | None = None,
    format: str | Iterable[str] = ["stl"],
    caps: Literal["aruco"] | None = None,
    scene: Ground | None = None,
    text: str | None = None,
    mirror: bool | None = None,
    set: Mapping[str, Any] = {},
    sweep: Name | None = None,
    progress: Progress | None = None,
) -> Report:
    """Write walkers as STL, 3MF, DXF or SVG files, one file per walker, or for MuJoCo.

    Example: `wg.export("koumakis2016", "walker.stl", tilt=10)`
    """

def check(
    design: Walker = "koumakis2016",
    *,
    tilt: float | Iterable[float] | str | None = None,
    legs: Kind | Iterable[Kind] | None = None,
    printer: Machine = "prusa-mk3s",
    text: str | None = None,
    mirror: bool | None = None,
    set: Mapping[str, Any] = {},
    copies: int | Mapping[float, int] | str = 1,
    strict: bool = False,
    weigh: bool = False,
    density: float = 1.24,
    scale: float = 1.0,
    progress: Progress | None = None,
) -> CheckReport | WeighReport:
    """Check whether walkers will print as designed, or weigh any mesh, without writing any file.

    With --weigh it reports the volume, mass, centre of mass, inertia tensor, principal moments and axes of a mesh file.

    Example: `wg.check(tilt=[5, 10], printer="ender3").warnings`
    """

def plate(
    design: Walker | None = None,
    *,
    tilt: float | Iterable[float] | str | None = None,
    legs: Kind | Iterable[Kind] | None = None,
    copies: int | Mapping[float, int] | str = 1,
    orders: Name | None = None,
    serial: int | None = None,
    caps: Literal["aruco"] | None = None,
    printer: Machine = "prusa-mk3s",
    text: str | None = None,
    mirror: bool | None = None,
    set: Mapping[str, Any] = {},
    max_parts: int = 5000,
    prusaslicer: bool = False,
    max_plates: int | None = None,
    how_many: bool = False,
    strict: bool = False,
    out: Name | None = None,
    pictures: bool = True,
    progress: Progress | None = None,
) -> Report:
    """Arrange copies of walkers on as many print-ready plates (3MF) as they need, with maps.

    Their design, tilts and copies are given here, or those of several designs by an order list.

    Example: `wg.plate("koumakis2016", tilt=[5, 10, 15], copies=8, out="out/plate")`
    """

def predict(
    design: Walker = "koumakis2016",
    scene: Ground | None = None,
    tilt: float | Iterable[float] | str | None = None,
    *,
    legs: Kind | Iterable[Kind] | None = None,
    restitution: float | None = None,
    friction: float | None = None,
    gamma: float | None = None,
    frequency: float | None = None,
    mode: Literal["coulomb", "paper"] = "coulomb",
    text: str | None = None,
    mirror: bool | None = None,
    set: Mapping[str, Any] = {},
    weights: Name | None = None,
    uncertain: bool = False,
    model: Literal["best", "known", "theory"] = "best",
    why: bool = False,
    progress: Progress | None = None,
) -> PredictReport:
    """Predict the speed of walkers, without writing any file.

    The table has the speed as designed, and the median and bounds for your print. Speeds come from a surrogate of the
    simulation. Outside its tested range they come from a simulation of a few seconds, which is cached. With
    --uncertain the report shows which input to measure next to narrow the bounds.

    Example: `wg.predict(tilt=10).speed`
    """

def sweep(
    design: Walker | None = None,
    scene: Ground | None = None,
    set: Mapping[str, Any] = {},
    *,
    model: str | None = None,
    error: str | None = None,
    sample: str | None = None,
    seed: int = 1,
    keep: str | Iterable[str] | None = None,
    printer: Machine | None = None,
    file: Name | None = None,
    wish: float | None = None,
    workers: int | None = None,
    dask: str | None = None,
    yes: bool = False,
    out: Name | None = None,
    pictures: bool = True,
    progress: Progress | None = None,
) -> SweepReport:
    """Map speeds over any keys of design and scene: a table and pictures, resumed when stopped.

    All combinations of the values are evaluated, the last key fastest; every one of them has every sample. Keys that
    begin with scene.crowd. map what crowds do. Points that were evaluated before are not evaluated again.

    Example: `wg.sweep(set={"legs.tilt_deg": [5, 10, 15]}).table["speed_mm_s"]`
    """

def simulate(
    design: Walker = "koumakis2016",
    scene: Ground | None = None,
    *,
    tilt: float | Iterable[float] | str | None = None,
    legs: Kind | Iterable[Kind] | None = None,
    seconds: float | None = None,
    runs: int | None = None,
    restitution: float | None = None,
    friction: float | None = None,
    gamma: float | None = None,
    frequency: float | None = None,
    step: float | None = None,
    effects: str | float | None = None,
    seed: int | None = None,
    text: str | None = None,
    mirror: bool | None = None,
    set: Mapping[str, Any] = {},
    trajectory: Name | None = None,
    rate_hz: float = 1000.0,
    error: str | None = None,
    uncertain: bool = False,
    draws: int = 64,
    out: Name | None = None,
    of: str = "speed_mm_s",
    all: bool = False,
    progress: Progress | None = None,
) -> SimulationReport:
    """Bounce a walker on the plate and measure its speed; on a plane also how it turns.

    Several tilts, or both kinds of legs, make a table. The first run compiles the simulator. With --error the number
    of runs, their length and the step are chosen to meet an error of the mean speed at 95 % confidence. A percentage
    refers to the speed, or to a fifth of the plate's peak speed if the walker is slower. With --effects the effects
    that change the speed less are measured first and left out.

    Example: `wg.simulate(tilt=10, seconds=1, runs=4).speed`
    """

def crowd(
    design: Walker | Card | None = None,
    scene: Ground | None = None,
    *,
    count: int | Mapping[str, int] | str | None = None,
    packing: float | None = None,
    arena: str | None = None,
    tilt: float | None = None,
    legs: Literal["flexible", "braced"] | None = None,
    seconds: float | None = None,
    runs: int | None = None,
    restitution: float | None = None,
    friction: float | None = None,
    gamma: float | None = None,
    frequency: float | None = None,
    step: float | None = None,
    seed: int | None = None,
    model: Literal["space", "flat"] | None = None,
    rate_hz: float = 25.0,
    threads: int | None = None,
    write_only: bool = False,
    card: bool = False,
    tracks: Name | None = None,
    fps: float | None = None,
    mm_per_px: float | str | None = None,
    unit: str | None = None,
    y_down: bool = False,
    set: Mapping[str, Any] = {},
    movie: Name | None = None,
    pictures: bool = True,
    out: Name | None = None,
    progress: Progress | None = None,
) -> Report:
    """Simulate many walkers that meet in a dish: order, clusters and packing with errors.

    Write a folder with a page, tables, figures and the tracks of every run. The same seed gives the same bytes on any
    number of threads. Each run starts from other places, and the scatter of the runs gives the errors. A card in place
    of a design makes a crowd of thousands in a plane. --card measures one walker for such a crowd, from simulated runs
    or from the tracks of a film.

    Example: `wg.crowd("koumakis2016", count=6, arena="disc:90", seconds=0.5, runs=2)`
    """

def movie(
    design: Walker = "koumakis2016",
    scene: Ground | None = None,
    *,
    tilt: float | Iterable[float] | str | None = None,
    legs: Kind | Iterable[Kind] | None = None,
    seconds: float | None = None,
    periods: float | None = None,
    slow: float | None = None,
    view: Literal["above", "perspective"] | None = None,
    fps: int = 25,
    restitution: float | None = None,
    friction: float | None = None,
    gamma: float | None = None,
    frequency: float | None = None,
    step: float | None = None,
    seed: int | None = None,
    text: str | None = None,
    mirror: bool | None = None,
    set: Mapping[str, Any] = {},
    out: Name | None = None,
    progress: Progress | None = None,
) -> Report:
    """Film a walker in slow motion, or several tilts from above (GIF and MP4).

    A single walker in a lane is shown in perspective and in slow motion. A walker on a plane, and several walkers, are
    shown from above in real time. --view above or --view perspective changes this.

    Example: `wg.movie("koumakis2016", "plane-90hz", tilt=[5, 10, 15], seconds=1, out="film.gif").files`
    """

def explain(
    design: Walker = "koumakis2016",
    scene: Ground | None = None,
    *,
    tilt: float | None = None,
    legs: Literal["flexible", "braced"] | None = None,
    friction: float | None = None,
    gamma: float | None = None,
    frequency: float | None = None,
    text: str | None = None,
    mirror: bool | None = None,
    set: Mapping[str, Any] = {},
    measure: bool = False,
    cost: bool = True,
    all: bool = False,
    out: Name | None = None,
    progress: Progress | None = None,
) -> Report:
    """Report which effects a scene has, how large they are, and what they change and cost.

    With --measure each effect is turned off, or on at its usual size, for ten seconds: alone, and the two largest
    together. The report has the changes of speed and CPU time, a picture, and the effects that can be left out.

    Example: `wg.explain("koumakis2016", "plane-noisy", cost=False)`
    """

def track(
    film: Name,
    *,
    mm_per_px: float | str | None = None,
    length: float | str | None = None,
    fps: float | None = None,
    frames: tuple[int, int | None] | str = (0, None),
    region: tuple[int, int, int, int] | str | None = None,
    walkers: Literal["dark", "light"] | None = None,
    threshold: float | None = None,
    width: float | None = None,
    heading: Literal["motion", "mark"] = "motion",
    markers: Literal["aruco"] | None = None,
    marker_mm: float | str | None = None,
    lens: Name | None = None,
    out: Name | None = None,
    progress: Progress | None = None,
) -> TrackReport:
    """Track walkers in a film from above: tracks.csv for analyse, and a picture to check.

    The walkers are of one size, on a ground of another brightness, seen straight from above. Give the scale by
    --mm-per-px or --length. With --markers the markers on caps give number, position and heading, the scale and the
    camera's tilt. --lens corrects lens distortion. Needs the extra film: pip install 'walkergen[film]'.

    Example: `wg.track("film.mp4", length=28)`
    """

def analyse(
    tracks: Any,
    *,
    fps: float | None = None,
    mm_per_px: float | str | None = None,
    unit: str | None = None,
    y_down: bool = False,
    lane: bool = False,
    lag_ms: float | None = None,
    descent_deg: float | None = None,
    arena: str | None = None,
    dish: str | None = None,
    body: str | float | None = None,
    middle: str | None = None,
    runs: Iterable[Name] = [],
    pictures: bool = True,
    out: Name | None = None,
    progress: Progress | None = None,
) -> AnalysisReport:
    """Measure speed, persistence and spread from tracks, filmed or simulated.

    A film is a table with columns frame or t_s, x, y and, if known, particle and theta (rad) or theta_deg, counted
    from x toward y; or a file of TrackMate, DeepLabCut, SLEAP, movement, idtracker.ai, TRex, FastTrack, MTrackJ or
    Tracker. Put units into the names (x_mm, "X (cm)"), or give --fps, --mm-per-px, --unit. A simulation is a
    file that simulate --trajectory wrote. Tracks at several plate speeds need a column plate_speed_mm_s. Python may
    give what track() or simulate().trajectory() returned, a frame of pandas, or columns by name.

    With --dish the walkers are a crowd: its packing, clusters, order and fluctuations are measured, with errors from
    independent runs (--run), and no single walkers.

    Example: `wg.analyse("tracks.csv", fps=50, mm_per_px=0.1).speed`
    """

def fit(
    speeds: Name,
    design: Walker = "koumakis2016",
    scene: Ground = "lane-90hz",
    *,
    model: Literal["prediction", "theory", "space"] = "prediction",
    fix: Mapping[str, float] | Iterable[str] = [],
    prior: Literal["flat", "scene"] | None = None,
    predict: float | Iterable[float] | str | None = None,
    mode: Literal["coulomb", "paper"] = "coulomb",
    seed: int | None = None,
    set: Mapping[str, Any] = {},
    pictures: bool = True,
    out: Name | None = None,
    progress: Progress | None = None,
) -> FitReport:
    """Estimate the contact from measured speeds, and predict walkers that were not measured.

    The CSV file has columns tilt_deg, speed_mm_s and, if known, speed_se_mm_s, legs (flexible or braced; otherwise the
    design's) and plate_speed_mm_s (otherwise the scene's). A row is one print, its standard error that of its film. In
    place of a speed, a column tracks may name the tracks.csv of a film: a row for each of its walkers, or for the one
    in a column particle. By default the fit takes seconds and uses the model of `predict`. A simulated model is fitted
    with emulators. Both give bands for one more print at every tilt. The theory, the paper's eq. 15, is fitted by least
    squares. All write scene.toml and design.toml for `walkergen family`.

    Example: `wg.fit("speeds.csv", predict=[12]).scene.contact`
    """

def calibrate(
    what: Name | None = None,
    design: Walker = "koumakis2016",
    scene: Ground = "lane-90hz",
    *,
    tilt: float | None = None,
    legs: Literal["flexible", "braced"] | None = None,
    restitution: float | None = None,
    friction: float | None = None,
    by: Literal["deflection", "ring", "both"] = "both",
    roll_deg: float = 1.0,
    drops: int = 24,
    seed: int | None = None,
    measured: float | None = None,
    measured_sd: float | None = None,
    tries: int = 1,
    height_mm: float = 10.0,
    printer: Machine = "prusa-mk3s",
    max_plates: int | None = None,
    prusaslicer: bool = False,
    strict: bool = False,
    plate: Name | None = None,
    set: Mapping[str, Any] = {},
    pictures: bool = True,
    out: Name | None = None,
    progress: Progress | None = None,
) -> Report:
    """Estimate Young's modulus, density, friction, damping and restitution from your readings.

    `calibrate plate` makes a plate to measure: strips of four thicknesses, a block and one walker, with a sheet and a
    form. Fill in the form with readings from a ruler and a phone, and run `calibrate FORM.csv`. It estimates what the
    form contains. Errors come from those of the readings and from their scatter. The results are written into
    design.toml and scene.toml for `family` and `simulate`. Other values stay as design and scene have them. For
    friction from the film of a slide, give the angle of the incline as filmed_deg, and the film's tracks.csv in a
    column tracks. A drop test of the walker is simulated (a minute); the rest takes a second.

    `calibrate --plate FILE.csv` takes a recording of a phone's accelerometer on the shaken plate (phyphox and others: a
    column of times, three of accelerations). It reports frequency and amplitude of the drive, second harmonic, motion
    along the plate and noise, each with its error, and writes them into scene.toml. Three columns of a gyroscope add
    how the amplitude changes over the plate, and how it rocks.

    `calibrate drop` estimates the restitution of the feet, at any tilt, from the rebound of a drop on a still plate
    (--measured: root of height over height). It simulates drops with each restitution.

    Example: `wg.calibrate("drop", roll_deg=0, drops=2, measured=0.64, measured_sd=0.05)`
    """

def accuracy(
    design: Walker = "koumakis2016",
    scene: Ground | None = None,
    *,
    tilt: float | None = None,
    legs: Literal["flexible", "braced"] | None = None,
    restitution: float | None = None,
    friction: float | None = None,
    set: Mapping[str, Any] = {},
    budget: str | float | None = None,
    out: Name | None = None,
    progress: Progress | None = None,
) -> Report:
    """Report the time that each accuracy of the mean speed takes; with --budget, measured for this walker.

    Example: `wg.accuracy(tilt=10, budget="5s").lines`
    """

def selftest(only: str | None = None, *, progress: Progress | None = None) -> Report:
    """Run the hard cases, each with an exact outcome or an invariant; exit code 1 if any fails.

    Example: `wg.selftest("6.4").code == 0`
    """
