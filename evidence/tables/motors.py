"""Walkers with a motor of their own, on a table: their rows, and their table by a process.

Two legs under a body on its side, as the template coinbot, and brushes and discs on three to twelve
legs, as bristlebot and spinner; coin motors in any named axis, anywhere in the body, with a coin
cell or without. Rows are a third of those of plates and depend on half as many numbers more: there a
process errs by less than networks, which learn nothing of them from what plates have
(docs/physics.md section 8).
"""

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from evidence.tables import fit, process
from evidence.tables.cases import ALL, Case, Group, Numbers, Ranges, tilt_of
from evidence.tables.fit import TENTHS
from evidence.tables.process import Values
from walkergen.drive import GRAVITY
from walkergen.numerics.odd_process import Process
from walkergen.points import worker_pool
from walkergen.scene import Arena, Contact, Drive, Feet, LegModel, Run, Scene
from walkergen.theory import motors, surrogate
from walkergen.walker import solids
from walkergen.walker.design import Design
from walkergen.walker.fittings import CELLS, Cell
from walkergen.walker.pockets import FLOOR_MM

Array = npt.NDArray[Any]

SEED = 40

COLUMNS = motors.NAMES
"""Columns of the numbers of a row."""

RUN = Run(seconds=0.6, discard_seconds=0.2, runs=4)
"""Runs of a row, 50 to 160 turns each: many rows with noise tell more than few without."""

MOTORS = (Cell(10.0, 2.7, 1.0), Cell(8.0, 2.5, 0.8), Cell(12.0, 3.4, 1.7))
"""Sizes and masses of common coin motors."""

CLEARANCE_MM, APART_MM = 0.2, 0.5
"""Gap round a part in its pocket, and the plastic between two pockets."""

OVER_LEG_MM = 0.1
"""Height of a pocket over the ends of legs, which reach into a quarter of the body."""

COMMON: Ranges = {
    "tilt_share": (0.0, 0.8),
    "restitution": (0.02, 1.0),
    "log_friction": (math.log(0.06), math.log(0.65)),
    "log_push": (math.log(1.1), math.log(6.5)),
    "log_frequency_hz": (math.log(80.0), math.log(260.0)),
    "thickness_mm": (0.35, 0.6),
    "unevenness_um": (-5.0, 13.0),
    "youngs_modulus_gpa": (2.2, 3.8),
    "size_share": (0.0, 1.0),
    "axis_share": (0.0, 1.0),
    "reversed_share": (0.0, 1.0),
    "along_share": (-1.0, 1.0),
    "across_share": (-2.5, 2.5),
    "up_mm": (0.0, 2.0),
    "cell_share": (0.0, 1.0),
    "cell_along_share": (0.0, 1.0),
}
"""Ranges of every walker with a motor. Its push is over the weight; negative unevenness means none;
of the place across the body the part within -1..1 is taken, and 0 beyond."""

PAIRS: Ranges = COMMON | {
    "length_mm": (5.5, 9.0),
    "span_share": (0.35, 0.75),
    "body_length_mm": (30.0, 44.0),
    "body_thickness_mm": (4.0, 8.0),
    "depth_share": (0.0, 1.0),
}
"""Two legs as deep as the body."""

MANY: Ranges = COMMON | {
    "length_mm": (4.5, 8.0),
    "span_share": (0.55, 0.85),
    "body_length_mm": (28.0, 42.0),
    "body_thickness_mm": (4.4, 6.0),
    "depth_share": (0.0, 1.0),
    "legs_share": (0.0, 1.0),
    "disc_share": (0.0, 1.0),
    "width_mm": (1.5, 5.0),
    "turned_share": (0.0, 1.0),
}
"""Brushes and discs."""

COUNTS = (3, 3, 4, 6, 8, 10, 12)
"""Numbers of legs of MANY; three stand as a tripod, others in two rows."""

DISCS = 0.4
"""Share of the walkers of three or four legs whose body is a disc."""

SUPPORTS = 300
"""Rows on which the process rests: of twice as many it errs by no less."""


def _case(value: Numbers) -> Case:
    """Walker and scene of a row. Raises GeometryError for one that cannot be built."""
    design = Design.model_validate(_design(value))
    weight = float(solids.mass_of(design).total) * GRAVITY
    frequency = math.exp(value["log_frequency_hz"])
    drive = Drive(
        kind="motor",
        frequency_hz=frequency,
        eccentric_g_mm=math.exp(value["log_push"]) * weight / (2.0 * math.pi * frequency) ** 2,
        reversed=value["reversed_share"] < 0.5,
    )
    scene = Scene(
        drive=drive,
        contact=Contact(restitution=value["restitution"], friction=math.exp(value["log_friction"])),
        arena=Arena(kind="plane"),
        legs=LegModel(model="space"),
        feet=Feet(unevenness_um=max(value["unevenness_um"], 0.0)),
        run=RUN,
        effects=ALL,
    )
    return Case(scene, design)


def _design(value: Numbers) -> dict[str, Any]:
    """Data of a walker with its motor, and with a cell where there is room for one."""
    cell = _of("LR44" if value["cell_share"] < 0.25 else "CR2032", value["cell_share"] < 0.8)
    tilt = tilt_of(value["tilt_share"])
    legs: Any
    length, thickness = value["body_length_mm"], value["body_thickness_mm"]
    if "legs_share" in value:
        body, legs = _many(value, cell)
        data: dict[str, Any] = {"legs": legs, "leg_tilt_deg": tilt}
    else:
        body = {"length_mm": length, "thickness_mm": thickness, "depth_mm": _depth(value, cell)}
        legs = {
            "tilt_deg": tilt,
            "length_mm": value["length_mm"],
            "contact_spacing_mm": value["span_share"] * length,
            "flexible_thickness_mm": value["thickness_mm"],
        }
        data = {"legs": legs}
    material = {"youngs_modulus_gpa": value["youngs_modulus_gpa"]}
    return data | {"body": body, "material": material} | _parts(value, body, cell)


def _of(shape: str, carried: bool) -> str | None:
    return shape if carried else None


def _depth(value: Numbers, cell: str | None) -> float:
    """Depth of a rectangular body, mm, with walls beside its cell."""
    wide = 0.0 if cell is None else CELLS[cell].diameter_mm
    least = max(wide + 2.0 * (CLEARANCE_MM + FLOOR_MM) + 0.2, 14.0)
    return least + 8.0 * value["depth_share"]


def _many(value: Numbers, cell: str | None) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Body in plan view or as a box, and its list of legs."""
    count = COUNTS[int(value["legs_share"] * len(COUNTS))]
    length, width = value["body_length_mm"], value["width_mm"]
    disc = count <= 4 and value["disc_share"] < DISCS
    body: dict[str, Any] = {"length_mm": length, "thickness_mm": value["body_thickness_mm"]}
    depth = length
    if disc:
        body["outline"] = "disc"
    else:
        depth = body["depth_mm"] = _depth(value, cell) + 4.0
    half = 0.5 * value["span_share"] * length * (0.85 if disc else 1.0)
    aside = 0.29 * length if disc else 0.5 * (depth - width) - 0.3
    if count == 3:
        ahead = -half if value["turned_share"] < 0.5 else half
        back = -ahead * (0.75 if disc else 1.0)
        places = [(back, -aside), (back, aside), (ahead, 0.0)]
    else:
        places = [
            (along, across) for across in (-aside, aside) for along in np.linspace(-half, half, count // 2).tolist()
        ]
    if disc and count == 4:
        places = [(0.7 * along, across) for along, across in places]
    legs = [
        {
            "length_mm": value["length_mm"],
            "along_mm": along,
            "across_mm": across,
            "width_mm": width,
            "thickness_mm": value["thickness_mm"],
        }
        for along, across in places
    ]
    return body, legs


def _parts(value: Numbers, body: dict[str, Any], cell: str | None) -> dict[str, Any]:
    """Motor and cell of a walker, each with its place: the motor where it shall be, the cell on the
    larger side of it.
    """
    size = MOTORS[int(value["size_share"] * len(MOTORS))]
    share = value["axis_share"]
    axis = "across" if share < 0.65 else "up" if share < 0.8 else "along"
    length, thickness = body["length_mm"], body["thickness_mm"]
    depth = body.get("depth_mm", length)
    half = {"along": 0.5 * size.diameter_mm, "across": 0.5 * size.diameter_mm, "up": 0.5 * size.diameter_mm}
    half[axis] = 0.5 * size.height_mm
    half = {key: one + CLEARANCE_MM for key, one in half.items()}
    over = OVER_LEG_MM - 0.25 * thickness
    room = 0.5 * length - FLOOR_MM - half["along"]
    along = value["along_share"] * room
    motor = {
        "diameter_mm": size.diameter_mm,
        "height_mm": size.height_mm,
        "mass_g": size.mass_g,
        "axis": axis,
        "along_mm": along,
        "up_mm": over + half["up"] + value["up_mm"],
        "opens": "up",
    }
    if abs(value["across_share"]) < 1.0:
        motor["across_mm"] = value["across_share"] * (0.5 * depth - FLOOR_MM - half["across"])
    if cell is None:
        return {"motor": motor}
    sign = -math.copysign(1.0, along)
    wide = 0.5 * CELLS[cell].diameter_mm + CLEARANCE_MM
    high = 0.5 * CELLS[cell].height_mm + CLEARANCE_MM
    # Distance of the cell from the middle, on the other side of the motor
    least, most = half["along"] + wide + APART_MM - abs(along), 0.5 * length - FLOOR_MM - wide
    if least > most:  # no room beside it: the motor makes way, up to the end of the body
        motor["along_mm"] = -sign * min(abs(along) + least - most, room)
        least = most
    place = sign * (least + value["cell_along_share"] * (most - least))
    battery = {"shape": cell, "axis": "up", "along_mm": place, "up_mm": over + high, "opens": "up"}
    return {"motor": motor, "battery": battery}


GROUPS = (Group(PAIRS, 2000, _case), Group(MANY, 800, _case))


def place(case: Case) -> tuple[Array, float]:
    """Numbers of a walker with a motor, and the peak speed of its swing, mm/s."""
    tabled = motors.placed(case.scene, case.design, solids.mass_of(case.design))
    return np.array([*tabled.place[: motors.SHARED], *tabled.beside]), tabled.swing


class Left(NamedTuple):
    """What processes that have not seen it say of each row, after asinh; shape (n,)."""

    centre: Array
    sd: Array
    """Their standard deviation, the row's own noise within."""


def table(simulated: Array, cores: int, supports: int = SUPPORTS) -> dict[str, Array]:
    """Arrays of the table, with the ranges of its numbers and errors by groups of rows."""
    rows = fit.rows_of(simulated)
    coordinates = motors.coordinates(rows.places)
    middle = np.r_[np.zeros(motors.ODD), coordinates[:, motors.ODD :].mean(axis=0)]
    scale = np.sqrt(((coordinates - middle) ** 2).mean(axis=0))
    scale = np.maximum(scale, np.ptp(coordinates, axis=0) / fit.WIDEST)
    arrays = {"middle": middle, "scale": np.where(scale > 0.0, scale, 1.0)}
    inputs = motors.scaled(arrays, rows.places)
    features, uneven = surrogate.features(motors.even(inputs)), motors.uneven(rows.places)
    arrays["prints"], noise, _ = fit.scatter(features, uneven, rows)
    given = Values(inputs, rows.y, noise)
    left = left_out(given, cores, supports)
    # Honest where lengths, learnt from the rows, promise too much of those left out
    widened = float(np.sqrt(np.mean(((left.centre - rows.y) / left.sd) ** 2)))
    arrays |= process.arrays_of(process.fitted(given, motors.ODD, supports, TENTHS))
    arrays["widened"] = np.array(max(widened, 1.0))
    wider = left._replace(sd=np.hypot(max(widened, 1.0) * np.sqrt(left.sd**2 - noise), noise**0.5))
    ranges = {name: ends(name, column) for name, column in zip(motors.NAMES, rows.places.T, strict=True)}
    return arrays | fit.facts(ranges, fit.errors(rows, wider.centre, wider.sd, _groups(rows.places)))


def ends(name: str, column: Array) -> list[float]:
    """Ends of the range of a number, with mirror images and upright walkers between them."""
    low, high = float(column.min()), float(column.max())
    if name in motors.SIGNED:
        return [-max(high, -low), max(high, -low)]
    return [0.0 if name == "root_tilt" else low, high]


def left_out(given: Values, cores: int, supports: int) -> Left:
    """What is said of the rows of each tenth by a process of the others."""
    tenth = fit.tenths(len(given.values))
    parts = [Values(*(column[tenth != k] for column in given)) for k in range(TENTHS)]
    centre, variance = np.empty(len(tenth)), np.empty(len(tenth))
    with worker_pool.local(cores) as pool:
        processes = list(pool.executor.map(_fitted, parts, [supports] * TENTHS, range(TENTHS)))
    for k, other in enumerate(processes):
        out = tenth == k
        centre[out], variance[out] = other(given.inputs[out])
    return Left(centre, np.sqrt(variance + given.noise))


def _fitted(given: Values, supports: int, seed: int) -> Process:
    """Process of values, on one thread: several are fitted at a time."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        return process.fitted(given, motors.ODD, supports, seed)


def _groups(places: Array) -> dict[str, npt.NDArray[np.bool_]]:
    """Rows of which errors are told."""
    of = dict(zip(motors.NAMES, places.T, strict=True))
    pairs = of["log_count"] < 1.0
    return {
        "all": np.ones(len(places), bool),
        "two legs": pairs,
        "three to twelve legs": ~pairs,
        "axis across": np.abs(of["axis_across"]) > 0.5,
        "axis along": np.abs(of["axis_along"]) > 0.5,
        "axis up": np.abs(of["axis_up"]) > 0.5,
        "push below 1.8 weights": of["gamma"] < 1.8,
        "push above 3 weights": of["gamma"] > 3.0,
    }
