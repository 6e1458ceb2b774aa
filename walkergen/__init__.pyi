# Made of the requests by packaging/stub.py
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
    speeds: bool = True,
    why: bool = False,
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

    Examples
    --------
    >>> import walkergen as wg
    >>> made = wg.family("koumakis2016", "mine", tilt=[5, 10], legs="flexible", pictures=False)
    >>> sorted(path.name for path in made.folder.iterdir())
    ['family.csv', 'family.md', 'manifest.json', 'plates', 'stl', 'weights.csv']
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

    Examples
    --------
    >>> import walkergen as wg
    >>> wg.export("koumakis2016", "walker.stl", tilt=10).files[0].name
    'walker.stl'
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

    Examples
    --------
    >>> import walkergen as wg
    >>> checked = wg.check(tilt=[5, 10], printer="ender3")
    >>> checked.table
    <table: 4 rows of wall, thickness_mm, lines, plastic_percent>
    >>> checked.warnings
    ()
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

    Examples
    --------
    >>> import walkergen as wg
    >>> wg.plate("koumakis2016", tilt=[5, 10], copies=2, out="plate", pictures=False)
    4 parts on 1 plate of prusa-mk3s
    plates: 2 rows
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

    Notes
    -----
    The surrogate is used where its error is at most 10 % or 1 mm/s, inside the ranges of its training set
    (docs/physics.md section 4). Bounds contain the contact, the print, the masses and a structural error of the model,
    10 % of the speed by default.

    References
    ----------
    N. Koumakis, A. Gnoli, C. Maggi, A. Puglisi and R. Di Leonardo, "Mechanism of self-propulsion in 3D-printed active
    granular particles", New Journal of Physics 18 (2016) 113046, eq. 15 (the theory's speed).

    Examples
    --------
    >>> import walkergen as wg
    >>> print(wg.predict(tilt=10).speed)
    51 ± 11 mm/s, with 95 % 33.6 to 73.8
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

    Notes
    -----
    In Python no files are written without a folder in `out`.

    Examples
    --------
    >>> import walkergen as wg
    >>> wg.sweep(set={"legs.tilt_deg": [5, 10]}).table["speed_mm_s"].round()
    array([31., 51.])
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

    Notes
    -----
    The walker moves in space on elastic feet with the scene's restitution and friction (docs/physics.md section 7).
    The bounds of a speed contain the scatter of the runs and the error of the time step.

    Examples
    --------
    >>> import walkergen as wg
    >>> runs = wg.simulate(tilt=10, seconds=0.1, runs=4)
    >>> runs.speed.low_95 < runs.speed.value < runs.speed.high_95
    True
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

    Notes
    -----
    Cards were tested against walkers in space, in a square without walls, up to a packing of 0.3 (docs/physics.md
    section 9). In Python no files are written without a folder in `out`.

    Examples
    --------
    The properties of one walker that a crowd in a plane needs. For a crowd in space give its number, as
    ``wg.crowd("koumakis2016", count=6, arena="disc:90", seconds=0.5, runs=2)``.

    >>> import walkergen as wg
    >>> measured = wg.crowd("koumakis2016", card=True, seconds=1, runs=4, pictures=False)
    >>> measured.table["quantity"][:3].tolist()
    ['speed_mm_s', 'sideways_mm_s', 'velocity_relaxation_s']
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

    Examples
    --------
    >>> import walkergen as wg
    >>> film = wg.movie("koumakis2016", tilt=10, periods=0.2, slow=100, fps=20, out="film.gif")
    >>> film.files[0].name
    'film.gif'
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
    """List the effects that a scene requires, with their size, influence and cost.

    Examples
    --------
    >>> import walkergen as wg
    >>> effects = wg.explain("koumakis2016", "plane-noisy", cost=False).table
    >>> [row["effect"] for row in effects if row["on"]][:3]
    ['flexible foot tensor', 'leg compliance', 'sticking in impacts']
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

    Examples
    --------
    The film shows three walkers of 28 mm.

    >>> import walkergen as wg
    >>> found = wg.track("film.mp4", length=28)
    >>> len(set(found.table["particle"]))
    3
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

    Notes
    -----
    The scale's own error is part of the errors only if it is given, as in mm_per_px="0.05±0.001". In Python no files
    are written without a folder in `out`.

    Examples
    --------
    >>> import walkergen as wg
    >>> tracks = wg.simulate(tilt=10, seconds=1, runs=4).trajectory(rate_hz=50)
    >>> found = wg.analyse(tracks)
    >>> 30 < found.speed.value < 90  # mm/s
    True
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

    Notes
    -----
    The report names the parameters that the speeds hardly constrain.

    References
    ----------
    N. Koumakis, A. Gnoli, C. Maggi, A. Puglisi and R. Di Leonardo, "Mechanism of self-propulsion in 3D-printed active
    granular particles", New Journal of Physics 18 (2016) 113046, eq. 15 (the model theory).

    Examples
    --------
    >>> import walkergen as wg
    >>> with open("speeds.csv", "w") as file:
    ...     for row in "tilt_deg,speed_mm_s", "5,60", "10,62", "20,25", "30,8":
    ...         print(row, file=file)
    >>> fitted = wg.fit("speeds.csv", model="theory", fix={"restitution": 0.8}, pictures=False)
    >>> round(fitted.scene.contact.friction, 2)
    0.17
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

    Examples
    --------
    >>> import walkergen as wg
    >>> made = wg.calibrate("plate", out="lab", pictures=False)
    >>> [path.name for path in made.files if path.suffix == ".3mf"]
    ['calibration_prusa-mk3s_1.3mf']
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
    """Show what accuracy costs in time; with a budget, measure it: steps, statistics, shape.

    Notes
    -----
    An error is the half-width of a 95 % interval, as a share of the speed. Bias and scatter are added in squares.

    Examples
    --------
    >>> import walkergen as wg
    >>> wg.accuracy(tilt=10)["accuracy"]["error"][-3:].tolist()
    ['5 %', '2 %', '1 %']
    """

def selftest(only: str | None = None, *, all: bool = False, progress: Progress | None = None) -> Report:
    """Run the hard cases, each with an exact outcome or an invariant; exit code 1 if any fails.

    Notes
    -----
    Section 6 of docs/physics.md lists the cases.

    Examples
    --------
    >>> import walkergen as wg
    >>> wg.selftest("6.4").code
    0
    """
