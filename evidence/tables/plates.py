"""Walkers on shaken plates: what people build most often, its neighbours and the rest; and their table of networks.

Every network is trained without two tenths of the rows, other tenths each, so that every row is
left out by two of them: their mean there says how well the table interpolates. The table itself is
the mean of all ten.
"""

import math
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from evidence.tables import fit
from evidence.tables import networks as nets
from evidence.tables.cases import ALL, Case, Group, Numbers, Ranges, tilt_of
from evidence.tables.fit import TENTHS, Rows
from evidence.tables.networks import Values
from walkergen.points import worker_pool
from walkergen.scene import Arena, Contact, Drive, Feet, LegModel, Plate, Run, Scene
from walkergen.theory import discrepancy, surrogate
from walkergen.theory.discrepancy import MOST_SLOPE_DEG, Layer
from walkergen.theory.surrogate import Place
from walkergen.walker import solids
from walkergen.walker.body import Body
from walkergen.walker.design import Design
from walkergen.walker.limbs import Kind, Legs

Array = npt.NDArray[Any]

SEED = 12

RUN = Run(seconds=1.5, discard_seconds=0.3, runs=6)
"""Runs of a row: 10.8 simulated seconds. Many rows with noise tell more than few without."""

PAPER: Ranges = {
    "tilt_share": (0.08, 0.9),
    "restitution": (0.03, 0.92),
    "log_friction": (math.log(0.08), math.log(0.45)),
    "gamma": (1.4, 2.6),
    "log_frequency_hz": (math.log(90.0), math.log(90.0)),
    "thickness_mm": (0.28, 0.62),
    "length_mm": (7.5, 7.5),
    "spacing_mm": (13.0, 13.0),
    "unevenness": (-0.1, 0.2),
    "body_length_mm": (28.0, 28.0),
    "body_thickness_mm": (3.0, 3.0),
    "depth_mm": (8.0, 8.0),
}
"""The paper's walker on its plate, in any contact. Tilts are those of `tilt_of`; negative
unevenness (over the plate's amplitude) means none."""

PRINTED: Ranges = PAPER | {
    "tilt_share": (0.0, 0.95),
    "log_friction": (math.log(0.17), math.log(0.33)),
    "gamma": (1.8, 1.8),
    "thickness_mm": (0.34, 0.47),
}
"""The same as its authors printed and drove it: the first walker that people ask about."""

PLATE: Ranges = PRINTED | {
    "tilt_share": (0.03, 0.92),
    "restitution": (0.05, 0.42),
    "log_friction": (math.log(0.2), math.log(0.3)),
    "thickness_mm": (0.37, 0.43),
}
"""The same in the contact of the paper's plate, and in its neighbourhood: a newcomer's numbers."""

USUAL: Ranges = PAPER | {
    "log_frequency_hz": (math.log(70.0), math.log(125.0)),
    "gamma": (1.3, 2.6),
    "length_mm": (6.0, 9.0),
    "spacing_mm": (11.0, 15.0),
    "body_length_mm": (24.0, 32.0),
    "body_thickness_mm": (2.5, 4.0),
    "depth_mm": (6.0, 10.0),
}
"""Walkers that people make of it."""

WIDE: Ranges = {
    "tilt_share": (0.0, 1.0),
    "restitution": (0.02, 1.0),
    "log_friction": (math.log(0.05), math.log(0.6)),
    "gamma": (1.1, 3.0),
    "log_frequency_hz": (math.log(50.0), math.log(150.0)),
    "thickness_mm": (0.25, 0.8),
    "length_mm": (5.0, 10.0),
    "spacing_mm": (9.0, 17.0),
    "unevenness": (-0.1, 0.25),
    "body_length_mm": (22.0, 36.0),
    "body_thickness_mm": (2.0, 5.0),
    "depth_mm": (5.0, 12.0),
}

EXTRAS: Ranges = {
    "harmonic_share": (0.0, 1.0),
    "harmonic_phase_deg": (-180.0, 180.0),
    "slope_share": (0.0, 1.0),
    "noise_share": (0.0, 1.0),
}
"""What most rows have none of: see `_extra`."""

NO_EXTRAS = dict.fromkeys(EXTRAS, 0.0)

WITH_EXTRA = 0.1
"""Share of the rows that have a second harmonic; the same share has a slope, and noise."""

MOST_HARMONIC, MOST_NOISE, MOST_SLOPE_RATIO = 0.5, 0.5, 0.8
"""Ratio of the second harmonic; rms of the plate's noise over its peak speed; tan(slope) over
friction, above which walkers soon slide off as they like."""


COLUMNS = ("braced", *Place._fields)
"""Columns of the numbers of a row; `braced` is 1 for braced legs."""

OUT = 2
"""Number of tenths of the rows that a network leaves out; there are as many networks as tenths."""

HIDDEN = {"flexible": (40, 40, 40), "braced": (8,)}
"""Widths of the networks' layers by kind of legs."""

DECAY, STEPS = 0.1, 1000

PAPERS_SHAPE, SAME = (7.5 / 13.0, -0.47, math.log(8.0 / 13.0)), 0.01
"""Length ratio, logarithms of gyration and width ratio of the paper's flexible walker."""


def _extra(share: float, most: float) -> float:
    """Value of an extra, 0 for most rows, else evenly up to `most`."""
    return most * max(0.0, 1.0 - (1.0 - share) / WITH_EXTRA)


def _signed_extra(share: float, most: float) -> float:
    """As `_extra`, evenly from -most to most."""
    beyond = (1.0 - share) / WITH_EXTRA
    return 0.0 if beyond >= 1.0 else most * (2.0 * beyond - 1.0)


def _case(kind: Kind, value: Numbers) -> Case:
    body = Body(length_mm=value["body_length_mm"], thickness_mm=value["body_thickness_mm"], depth_mm=value["depth_mm"])
    legs: dict[str, Any] = {
        "kind": kind,
        "tilt_deg": tilt_of(value["tilt_share"]),
        "length_mm": value["length_mm"],
        "contact_spacing_mm": value["spacing_mm"],
    }
    if kind == "flexible":
        legs["flexible_thickness_mm"] = value["thickness_mm"]
    friction = math.exp(value["log_friction"])
    harmonic = _extra(value["harmonic_share"], MOST_HARMONIC)
    drive = Drive(
        frequency_hz=math.exp(value["log_frequency_hz"]),
        gamma=value["gamma"],
        second_harmonic_ratio=harmonic,
        second_harmonic_phase_deg=value["harmonic_phase_deg"] if harmonic else 0.0,
    )
    most = min(math.radians(MOST_SLOPE_DEG), math.atan(MOST_SLOPE_RATIO * friction))
    plate = Plate(
        slope_deg=math.degrees(_signed_extra(value["slope_share"], most)),
        noise_ratio=_extra(value["noise_share"], MOST_NOISE),
    )
    scene = Scene(
        drive=drive,
        contact=Contact(restitution=value["restitution"], friction=friction),
        plate=plate,
        arena=Arena(kind="plane"),
        legs=LegModel(model="space"),
        feet=Feet(unevenness_um=1e3 * drive.amplitude * max(value["unevenness"], 0.0)),
        run=RUN,
        effects=ALL,
    )
    return Case(scene, Design(body=body, legs=Legs(**legs)))


def _group(kind: Kind, ranges: Ranges, rows: int, extras: bool = True) -> Group:
    """Rows of a kind of legs; without `extras` they have no second harmonic, slope and noise."""
    return Group(ranges | EXTRAS, rows, partial(_case, kind), {} if extras else NO_EXTRAS)


GROUPS = (
    _group("flexible", PRINTED, 2100, extras=False),
    _group("flexible", PAPER, 1800),
    _group("flexible", USUAL, 1020),
    _group("flexible", WIDE, 840),
    _group("braced", USUAL, 240),
    _group("flexible", PLATE, 700, extras=False),
)


def place(case: Case) -> tuple[Array, float]:
    """Numbers of a walker on a shaken plate, and the plate's peak speed, mm/s."""
    numbers = discrepancy.place_of(case.scene, case.design, solids.mass_of(case.design))
    return np.array([case.design.rigid, *numbers]), case.scene.drive.peak_speed


def table(simulated: Array, cores: int, steps: int = STEPS) -> dict[str, Array]:
    """Arrays of the table, with ranges of places and errors by kind of legs."""
    arrays: dict[str, Array] = {}
    ranges, errors = {}, {}
    for kind in ("flexible", "braced"):
        rows = fit.rows_of(simulated[simulated[:, 0] == (kind == "braced")][:, 1:])
        low, high = Place(*rows.places.min(axis=0)), Place(*rows.places.max(axis=0))
        # Mirror images, and upright walkers between them, are in the table too
        steepest = max(high.slope_ratio, -low.slope_ratio)
        low = low._replace(root_tilt=0.0, slope_ratio=-steepest)
        high = high._replace(slope_ratio=steepest)
        ranges[kind] = {name: [float(getattr(low, name)), float(getattr(high, name))] for name in Place._fields}
        of_kind, errors[kind] = _of_kind(kind, rows, cores, steps)
        arrays |= of_kind
    return arrays | fit.facts(ranges, errors)


def _of_kind(kind: str, rows: Rows, cores: int, steps: int) -> tuple[dict[str, Array], dict[str, Any]]:
    """Arrays of one kind of legs, and its errors by groups of rows."""
    inputs, factors = discrepancy.coordinates(rows.places)
    middle = inputs.mean(axis=0)
    scale = np.maximum(inputs.std(axis=0), np.ptp(inputs, axis=0) / fit.WIDEST)  # most have no extras
    scale = np.where(scale > 0.0, scale, 1.0)
    inputs = (inputs - middle) / scale
    features = surrogate.features(inputs)
    uneven = np.asarray(Place(*rows.places.T).unevenness_ratio)
    between, noise, weights = fit.scatter(features, uneven, rows)
    training = Values(inputs, factors, rows.y, weights)
    tenth = fit.tenths(len(rows.y))
    trained, left_out = networks(training, tenth, HIDDEN[kind], cores, steps)
    error = fit.log_sd(features, left_out - rows.y, noise)
    arrays = {
        **nets.arrays_of(trained, kind),
        f"{kind}_middle": middle,
        f"{kind}_scale": scale,
        f"{kind}_error": error,
        f"{kind}_prints": between,
    }
    sd = np.hypot(np.sqrt(noise), surrogate.smooth(features, error))
    return arrays, fit.errors(rows, left_out, sd, _groups(rows.places))


def networks(
    training: Values, tenth: Array, hidden: tuple[int, ...], cores: int, steps: int
) -> tuple[list[list[Layer]], Array]:
    """The networks, and values at every row by those that have not seen it."""
    trained_on = [((tenth - k) % TENTHS) >= OUT for k in range(TENTHS)]
    parts = [Values(*(column[rows] for column in training)) for rows in trained_on]
    with worker_pool.local(cores) as pool:
        trained = list(pool.executor.map(_trained, parts, [hidden] * TENTHS, [steps] * TENTHS, range(TENTHS)))
    total = np.zeros(len(training.values))
    for layers, rows in zip(trained, trained_on, strict=True):
        outputs = discrepancy.evaluated(layers, training.inputs[~rows])
        total[~rows] += (outputs * training.factors[~rows]).sum(axis=1) / OUT
    return trained, total


def _trained(training: Values, hidden: tuple[int, ...], steps: int, seed: int) -> list[Layer]:
    """A network, on one thread: several are trained at a time."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        return nets.trained(training, hidden, DECAY, steps, seed)


def _groups(places: Array) -> dict[str, npt.NDArray[np.bool_]]:
    """Rows of which errors are told: all, by what they have beside the usual, and the paper's."""
    place = Place(*places.T)
    slope, noise = place.slope_ratio != 0.0, place.noise_ratio != 0.0
    harmonic = np.hypot(place.harmonic_cos, place.harmonic_sin) != 0.0
    plain = ~(slope | noise | harmonic)
    shapes = np.column_stack([place.length_ratio, place.log_gyration_ratio, place.log_width_ratio])
    shape = np.abs(shapes - PAPERS_SHAPE).max(axis=1) < SAME
    return {
        "all": np.ones(len(places), bool),
        "paper's walker": plain & shape,
        "other walkers": plain & ~shape,
        "second harmonic": harmonic,
        "slope": slope,
        "noise": noise,
    }
