"""Uncertain inputs of a prediction: values of design and scene with a standard deviation, and draws of them.

Every input has a mean and a standard deviation in keys of a file. Prediction, simulation and fit use the same list,
each with the inputs that it reads.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from statistics import NormalDist
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.core.drive import MOTOR_FREQUENCY_RANGE_HZ, Drive
from walkergen.core.scene import MIN_RESTITUTION, PRIORS, Scene
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.limbs import MAX_LENGTH_MM, MIN_LENGTH_MM
from walkergen.core.walker.mass import MassProperties, scale_masses

if TYPE_CHECKING:
    from walkergen.core.numerics.quantity import Quantity

Array = npt.NDArray[np.float64]

PREDICTION_READER, SPACE_READER = "prediction", "space"
"""Users of uncertain inputs: the prediction, and runs of the model in space."""

FREQUENCY_KEY, MOMENT_KEY = "drive.frequency_hz", "drive.eccentric_g_mm"
"""Names of the uncertain inputs of a motor."""

QUANTILES = (0.025, 0.16, 0.84, 0.975)
"""Ends of the bounds of 95 and 68 %."""

SHARE_POINTS, SHARE_SETS = 512, 8
"""Number of points of one set that give the shares, and number of sets; the scatter of the
sets is the error of the shares."""


class Input(NamedTuple):
    """Normal or log-normal distribution of an uncertain input, truncated to its valid range."""

    name: str
    """Key in design or scene; masses are ratios to those of the mesh or the balance."""
    mean: float
    sd: float
    low: float = 0.0
    high: float = math.inf
    folded: bool = False
    """True when the magnitude of the draws counts, as of a standard deviation itself uncertain."""
    factor: bool = False
    """True for a log-normal distribution of median `mean`, `sd` the logarithm of its standard factor."""


def inputs(scene: Scene, design: Design, reader: str) -> tuple[Input, ...]:
    """Return the uncertain inputs (standard deviation above 0) that PREDICTION_READER or SPACE_READER uses."""
    contact, feet = scene.contact, scene.feet
    mass_sd = 0.01 * design.weighed.mass_sd_percent
    candidates = (
        Input("contact.restitution", contact.restitution, contact.restitution_sd, MIN_RESTITUTION, 1.0),
        Input("contact.friction", contact.friction, contact.friction_sd),
        Input(
            "legs.thickness_mm",
            design.limbs[0].thickness,
            design.limbs[0].thickness_sd,
            0.25 * design.limbs[0].thickness,
            4.0 * design.limbs[0].thickness,
        ),
        Input(
            "material.youngs_modulus_gpa",
            design.material.youngs_modulus_gpa,
            design.material.youngs_modulus_sd_gpa,
            0.1 * design.material.youngs_modulus_gpa,
        ),
        Input("legs.damping_ratio", scene.legs.damping_ratio, scene.legs.damping_ratio_sd),
        Input("body mass", 1.0, mass_sd, 0.01),
        Input("leg mass", 1.0, mass_sd, 0.01),
        Input("feet.unevenness_um", feet.unevenness_um, feet.unevenness_sd_um, folded=True),
        _tip_radius(scene),
        *_motor_inputs(scene.drive),
    )
    excluded = {"legs.damping_ratio"} if reader == PREDICTION_READER else set()
    if design.rigid:
        excluded.add("leg mass")
    if scene.feet.rigid_tips:
        excluded.add("feet.tip_radius_um")
    if "unevenness" in scene.effects.off:
        excluded.add("feet.unevenness_um")
    return tuple(candidate for candidate in candidates if candidate.sd > 0 and candidate.name not in excluded)


def _tip_radius(scene: Scene) -> Input:
    """Return the distribution of the tips' effective radius, um, cut off at three standard deviations."""
    radius, factor = scene.feet.tip_radius_um, scene.feet.tip_radius_sd_factor
    factor = PRIORS[scene.contact.prior].tip_radius_sd_factor if factor is None else factor
    ends = radius / factor**3, radius * factor**3
    return Input("feet.tip_radius_um", radius, math.log(factor), *ends, factor=True)


def _motor_inputs(drive: Drive) -> tuple[Input, ...]:
    """Return distributions of a motor's frequency and moment, cut off at half and twice the mean; () for a plate."""
    if drive.kind == "plate":
        return ()
    pace, moment = drive.frequency, drive.eccentric_moment
    return (
        Input(
            FREQUENCY_KEY,
            pace,
            drive.frequency_sd_hz,
            max(0.5 * pace, MOTOR_FREQUENCY_RANGE_HZ[0]),
            min(2.0 * pace, MOTOR_FREQUENCY_RANGE_HZ[1]),
        ),
        Input(MOMENT_KEY, moment, drive.eccentric_sd_g_mm, 0.5 * moment, 2.0 * moment),
    )


class Drawn(NamedTuple):
    """Random draws of uncertain inputs, by the names of the inputs."""

    columns: Mapping[str, Array]
    """Values of each input, shape (number,)."""
    number: int

    def input_values(self, name: str, nominal: float) -> Array:
        """Return the drawn values of the input `name`, shape (number,); `nominal` everywhere if it is not uncertain."""
        return self.columns.get(name, np.full(self.number, nominal))


def label_columns(quantities: Sequence[Input], values: Array) -> Drawn:
    """Return `Drawn` with the columns of `values`, shape (count, inputs), by the names of the inputs `quantities`."""
    columns = {quantity.name: values[:, column] for column, quantity in enumerate(quantities)}
    return Drawn(columns, len(values))


def sample_inputs(quantities: Sequence[Input], count: int, seed: int) -> Array:
    """Return `count` draws of the inputs, shape (count, inputs), evenly spread by `lattice_points`, read-only."""
    return _sample_inputs(tuple(quantities), count, seed)


@lru_cache(maxsize=8)
def _sample_inputs(quantities: tuple[Input, ...], count: int, seed: int) -> Array:
    """Return draws as `sample_inputs` does, cached by the arguments."""
    points = lattice_points(len(quantities), count, seed)
    columns = [input_quantiles(quantity, points[:, column]) for column, quantity in enumerate(quantities)]
    drawn = np.column_stack(columns) if columns else np.empty((count, 0))
    drawn.flags.writeable = False
    return drawn


LATTICE_VECTOR = (
    *(1, 182667, 469891, 498753, 110745, 446247, 250185, 118627, 245333, 283199, 408519, 391023, 246327),
    *(126539, 399185, 461527, 300343, 69681, 516695, 436179, 106383, 238523, 413283, 70841, 47719, 300129),
    *(113029, 123925, 410745, 211325, 17489, 511893),
)
"""Generating vector of a lattice whose first 2^m points, m up to 20, are each a good lattice
(R. Cools, F. Y. Kuo and D. Nuyens, SIAM J. Sci. Comput. 28, 2162, 2006)."""


def lattice_points(dimension: int, count: int, seed: int) -> Array:
    """Return points of a randomly shifted lattice in the unit cube, shape (count, dimension), dimension <= 32.

    The first 2^m points are evenly spread. Errors of bounds over 512 of them are 0.4 to 0.8 of those with random
    numbers, and up to a third larger than with Sobol points, whose import takes a third of a second.
    """
    bits = max(math.ceil(math.log2(max(count, 1))), 1)
    indices, reversed_bits = np.arange(2**bits), np.zeros(2**bits, np.int64)
    for bit in range(bits):
        reversed_bits |= (indices >> bit & 1) << (bits - 1 - bit)
    points = reversed_bits[:count, None] * np.array(LATTICE_VECTOR[:dimension]) % 2**bits / 2**bits
    return np.asarray((points + np.random.default_rng(seed).random(dimension)) % 1.0)


STANDARD_NORMAL = NormalDist()
_normal_quantiles = np.vectorize(STANDARD_NORMAL.inv_cdf, otypes=[float])


def input_quantiles(law: Input, shares: Array) -> Array:
    """Return the quantiles of the distribution `law` of an input at probabilities `shares` in (0, 1), any shape."""
    if law.factor:
        normal = Input(law.name, math.log(law.mean), law.sd, math.log(law.low), math.log(law.high))
        return np.asarray(np.exp(input_quantiles(normal, shares)))
    low = -math.inf if law.folded else (law.low - law.mean) / law.sd
    high = math.inf if law.folded else (law.high - law.mean) / law.sd
    bottom, top = STANDARD_NORMAL.cdf(low), STANDARD_NORMAL.cdf(high)
    tiny = np.finfo(float).tiny
    within = np.clip(bottom + shares * (top - bottom), tiny, 1.0 - np.finfo(float).eps)
    values = np.asarray(law.mean + law.sd * _normal_quantiles(within))
    return np.asarray(np.abs(values) if law.folded else np.clip(values, law.low, law.high))


def apply_inputs(scene: Scene, design: Design, values: Mapping[str, float]) -> tuple[Scene, Design, MassProperties]:
    """Return copies of scene and design, and the masses, with the inputs named in `values` set to these values.

    Other inputs are unchanged. Feet of another material change in proportion to the scene's contact. Raises
    GeometryError for legs that cannot be built so thick.
    """
    changes: dict[str, dict[str, Any]] = {}
    for name, value in values.items():
        table, _, key = name.partition(".")
        if key:
            changes.setdefault(table, {})[key] = float(value)
    legs = changes.pop("legs", {})
    thickness = legs.pop("thickness_mm", None)
    material = changes.pop("material", {})
    if legs:
        changes["legs"] = legs
    drawn = scene.model_copy(
        update={name: getattr(scene, name).model_copy(update=new) for name, new in changes.items()}
    )
    design = _scale_foot_contacts(_with_leg_thickness(design, thickness, material), scene, drawn)
    body, leg = values.get("body mass", 1.0), values.get("leg mass", 1.0)
    return drawn, design, scale_masses(solids.mass_of(design), float(body), float(leg))


def scale_proportionally(own: float, drawn: Any, nominal: float, upper_limit: float = math.inf) -> Any:
    """Return `own`, a foot's own friction or restitution, times drawn / nominal, up to `upper_limit`.

    `nominal` is the scene's value, `drawn` its value in a draw or several. If `nominal` is 0, `own` is returned.
    """
    return own + 0.0 * drawn if nominal == 0.0 else np.minimum(own * (drawn / nominal), upper_limit)


def _scale_foot_contacts(design: Design, scene: Scene, drawn: Scene) -> Design:
    """Return the design with feet of another material scaled as the contact changes from `scene` to `drawn`."""
    if all(limb.friction is None and limb.restitution is None for limb in design.limbs):
        return design
    data = design.model_dump(exclude_unset=True)
    for leg in data["legs"]:
        for key, upper_limit in (("friction", math.inf), ("restitution", 1.0)):
            if leg.get(key) is not None:
                drawn_value, nominal = (getattr(source.contact, key) for source in (drawn, scene))
                leg[key] = float(scale_proportionally(leg[key], drawn_value, nominal, upper_limit))
    return Design.model_validate(data)


def _clip_thickness(thickness: float) -> float:
    """Return the drawn thickness of a leg, mm, limited to the range of a design."""
    return min(max(thickness, MIN_LENGTH_MM), MAX_LENGTH_MM)


def _with_leg_thickness(design: Design, thickness: float | None, material: dict[str, Any]) -> Design:
    """Return the design with its first leg of another thickness (mm), others in proportion, and material values."""
    ratio = 1.0 if thickness is None else thickness / design.limbs[0].thickness
    scaled = [_clip_thickness(ratio * limb.thickness) for limb in design.limbs]
    if thickness is not None and not design.is_complete_mesh:
        data = design.model_dump(exclude_unset=True)
        if design.has_legs_table:
            data.setdefault("legs", {})[f"{design.kind}_thickness_mm"] = _clip_thickness(thickness)
        else:
            for leg, leg_thickness in zip(data["legs"], scaled, strict=True):
                leg["thickness_mm"] = leg_thickness
        design = Design.model_validate(data)
    if material:
        design = design.model_copy(update={"material": design.material.model_copy(update=material)})
    return design.with_leg_thicknesses(scaled) if thickness is not None and design.is_complete_mesh else design


class Share(NamedTuple):
    """Part of a variance that an input causes (Saltelli et al. 2010)."""

    name: str
    first: "Quantity"
    """Part that knowing this input alone would remove."""
    total: "Quantity"
    """Part that would remain if all but this input were known."""


def variance_shares(quantities: Sequence[Input], function: Callable[[Array], Array], seed: int) -> tuple[Share, ...]:
    """Return the first-order and total shares of the inputs in a function's variance, largest total first.

    The function takes values of the inputs, shape (n, inputs), and returns shape (n,). Standard
    errors come from `SHARE_SETS` independent sets of points.
    """
    generators = np.random.default_rng(seed).spawn(SHARE_SETS)
    indices = np.array([sobol_indices(quantities, function, generator) for generator in generators])
    return sort_shares(quantities, indices.mean(axis=0), indices.std(axis=0, ddof=1) / math.sqrt(SHARE_SETS))


def sobol_indices(quantities: Sequence[Input], function: Callable[[Array], Array], rng: np.random.Generator) -> Array:
    """Return each input's first-order and total share of a function's variance, as `variance_shares`: (2, inputs)."""
    from scipy.stats import sobol_indices

    if not quantities:
        return np.empty((2, 0))
    laws = [_Law(quantity) for quantity in quantities]
    sobol = sobol_indices(func=lambda x: function(x.T), n=SHARE_POINTS, dists=laws, rng=rng)
    return np.array([np.ravel(sobol.first_order), np.ravel(sobol.total_order)])


def sort_shares(quantities: Sequence[Input], values: Array, errors: Array) -> tuple[Share, ...]:
    """Return the inputs' shares of a variance, largest total first. `values`, `errors`: first, total, (2, inputs)."""
    from walkergen.core.numerics.quantity import Quantity

    rows = [
        Share(
            uncertain.name,
            *(Quantity(("first", "total")[i], "", float(values[i, k]), float(errors[i, k])) for i in (0, 1)),
        )
        for k, uncertain in enumerate(quantities)
    ]
    return tuple(sorted(rows, key=lambda share: -share.total.number))


class _Law(NamedTuple):
    """Distribution of an input with the interface of scipy.stats."""

    input: Input

    def ppf(self, shares: Array) -> Array:
        """Return quantiles of the input at `shares`, probabilities in (0, 1)."""
        return input_quantiles(self.input, shares)
