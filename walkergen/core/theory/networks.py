"""Networks of the surrogate: speeds of walkers, their error and the chance of a fall, from the shipped file.

The networks' scale is asinh of a speed over the plate's. Rows of arrays are walkers or draws (`to_matrix`). Each of
ten networks of the speed was trained without another two tenths of the rows (evidence/tables). Their error has two
parts: their standard deviation, and the error that other networks learnt from rows not used in training.
"""

import hashlib
import io
import json
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import BadZipFile

import numpy as np
import numpy.typing as npt

from walkergen.core.errors import InputError
from walkergen.core.theory.dimensionless import DimensionlessNumbers
from walkergen.core.walker.limbs import Kind

Array = npt.NDArray[np.float64]

NETWORK_FILE = Path(__file__).with_name("surrogate.npz")

LINEAR_BELOW = 0.25
"""Speed over the plate's peak speed below which the networks' scale, asinh, is about linear: slow walkers
scatter by an amount, fast ones by a share."""

MAX_LOG_FRICTION_RATIO = 2.5
"""Logarithm of tan(tilt) over friction beyond which feet stick, or slide, as they do at it."""

SMALL_TILT_DEG = 1.0
"""Tilt at which speeds of small tilts, which are in proportion to it, begin to level off."""

MAX_FEATURE_SD = 3.0
"""Standard deviations beyond which a feature of a smooth function keeps its value."""

EXPONENT_RANGE = (-6.0, 1.0)
"""Exponents of a smooth function: beyond these it is as there."""

BLOCK_SIZE = 96
"""Inputs that are evaluated together: products so small that no library shares them out to threads."""


class Speeds(NamedTuple):
    """Speeds of n walkers over the plate's peak speed, on the networks' scale (asinh); arrays of shape (n,).

    They are normally distributed after asinh, so that errors are added there, before the conversion to mm/s.
    """

    centre: Array
    error: Array
    """Standard error of the networks."""
    between_prints: Array
    """Standard deviation between prints of one walker, because their feet are uneven."""
    falls: Array
    """Chance that a run ends in a fall."""
    each: Array
    """Value of `centre` from each single network, shape (networks, n)."""

    def speed_ratios(self, deviation: Array | float) -> Array:
        """Return speeds over the plate's peak speed, shape (n,), for `centre` + `deviation` on the networks' scale."""
        return np.asarray(LINEAR_BELOW * np.sinh(self.centre + deviation))


class Layer(NamedTuple):
    """One layer of several networks."""

    weights: Array
    """Shape (networks, inputs, outputs)."""
    bias: Array
    """Shape (networks, 1, outputs)."""


@cache
def load_arrays() -> Mapping[str, Any]:
    """Load the arrays of the surrogate's file, by name. Raises InputError for a damaged file."""
    try:
        with np.load(io.BytesIO(NETWORK_FILE.read_bytes())) as stored:
            arrays = {name: stored[name] for name in stored.files}
        is_intact = str(arrays.pop("digest")) == hash_arrays(arrays)
    except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
        raise InputError(f"{NETWORK_FILE}: the surrogate cannot be read: {error}. Install walkergen again.") from None
    if not is_intact:
        raise InputError(f"{NETWORK_FILE}: the surrogate was changed or truncated. Install walkergen again.")
    return arrays


def hash_arrays(arrays: Mapping[str, Any]) -> str:
    """Return a hash of named arrays, 32 hexadecimal digits."""
    hasher = hashlib.sha256()
    for name in sorted(arrays):
        value = np.ascontiguousarray(arrays[name])
        hasher.update(f"{name} {value.dtype} {value.shape}".encode() + value.tobytes())
    return hasher.hexdigest()[:32]


@cache
def digest() -> str:
    """Return the hash of the surrogate's arrays. Bounds of two families are comparable if their hashes are equal."""
    return hash_arrays(load_arrays())


@cache
def training_facts() -> dict[str, Any]:
    """Return facts on the surrogate's training, by key: ranges of its inputs, and errors outside the training set."""
    stored: dict[str, Any] = json.loads(str(load_arrays()["facts"]))
    return stored


def select_layers(arrays: Mapping[str, Any], name: str) -> tuple[Layer, ...]:
    """Return the layers, first to last, of the networks called `name`. `arrays`: those of the surrogate's file."""
    layers: list[Layer] = []
    while f"{name}_weights{len(layers)}" in arrays:
        layers.append(Layer(arrays[f"{name}_weights{len(layers)}"], arrays[f"{name}_bias{len(layers)}"]))
    return tuple(layers)


def evaluate(layers: Sequence[Layer], inputs: Array) -> Array:
    """Compute the networks' outputs, shape (networks, n, outputs), at inputs of shape (n, d), in single precision."""
    starts = range(0, len(inputs), BLOCK_SIZE)
    return np.concatenate([_forward_pass(layers, inputs[k : k + BLOCK_SIZE]) for k in starts], axis=-2)


def _forward_pass(layers: Sequence[Layer], inputs: Array) -> Array:
    """Compute the networks' outputs as `evaluate` does, for one block of inputs."""
    values = inputs.astype(np.float32)
    for layer in layers[:-1]:
        values = np.matmul(values, layer.weights)
        values += layer.bias
        values *= 0.5 + 0.5 * np.tanh(0.5 * values)  # SiLU, without overflow
    return np.asarray(np.matmul(values, layers[-1].weights) + layers[-1].bias)


def network_inputs(rows: Array) -> tuple[Array, Array]:
    """Return the networks' inputs for n walkers, shape (n, d), and the factors of their two outputs, shape (n, 2).

    Speeds change most where the tilt passes the angle of friction, where feet stick. Tilt and slope change sign when
    walker and plate are mirrored. Inputs contain only products of both, and the factors are odd in them. So a walker
    without tilt on a level plate has no speed, and a mirror image the opposite one.
    """
    numbers = DimensionlessNumbers(*rows.T)
    tilt = numbers.root_tilt**2
    odd = tilt / (tilt + SMALL_TILT_DEG)
    log_ratio = np.log(np.tan(np.radians(np.maximum(tilt, 1e-3)))) - numbers.log_friction
    plain = numbers._replace(
        slope_ratio=odd * numbers.slope_ratio,
        unevenness_ratio=np.sqrt(numbers.unevenness_ratio),
        wall_friction=numbers.closeness * numbers.wall_friction,
        wall_restitution=numbers.closeness * numbers.wall_restitution,
        log_body_ratio=numbers.closeness * numbers.log_body_ratio,
        log_depth_ratio=numbers.closeness * numbers.log_depth_ratio,
    )
    more = (
        tilt,
        np.clip(log_ratio, -MAX_LOG_FRICTION_RATIO, MAX_LOG_FRICTION_RATIO),
        np.log(numbers.gamma),
        numbers.slope_ratio**2,
        np.hypot(numbers.harmonic_cos, numbers.harmonic_sin),
        np.sign(numbers.closeness),
    )
    return np.column_stack([*plain, *more]), np.column_stack([odd, numbers.slope_ratio])


def features(inputs: Array) -> Array:
    """Return the features for `evaluate_smooth`, shape (n, 1 + 2 d): 1, the `inputs` (n, d), and their squares."""
    near = np.clip(inputs, -MAX_FEATURE_SD, MAX_FEATURE_SD)
    return np.column_stack([np.ones(len(inputs)), near, near**2])


def evaluate_smooth(terms: Array, weights: Array) -> Array:
    """Return exp(`terms` @ `weights`), shape (n,), a positive function of the features `terms`, shape (n, m)."""
    return np.asarray(np.exp(np.clip(terms @ weights, *EXPONENT_RANGE)))


def error_factor(odd: Array) -> Array:
    """Return factors of errors, 0 to 1, shape (n,): 0 without tilt on a level plate. `odd`: from `network_inputs`."""
    return np.asarray(np.minimum(np.abs(odd).sum(axis=1), 1.0))


def error_parts(values: Array, log_error: Sequence[Layer], inputs: Array, odd: Array) -> Array:
    """Return two errors (2, n) of `values` (networks, n): their scatter, and what the networks `log_error` predict."""
    learnt = np.exp(evaluate(log_error, inputs)[..., 0].mean(axis=0))
    return np.stack([values.std(axis=0, ddof=1), learnt * error_factor(odd)])


def speeds_at(kind: Kind, rows: Array) -> Speeds:
    """Return the speeds of n walkers with legs of a kind. `rows`: their dimensionless numbers, shape (n, fields)."""
    arrays = load_arrays()
    plain, odd = network_inputs(rows)
    inputs = (plain - arrays[f"{kind}_middle"]) / arrays[f"{kind}_scale"]
    values = (evaluate(select_layers(arrays, kind), inputs) * odd).sum(axis=-1)
    terms, uneven = features(inputs), rows[:, DimensionlessNumbers._fields.index("unevenness_ratio")]
    prints = uneven * evaluate_smooth(terms, arrays[f"{kind}_prints"])
    parts = error_parts(values, select_layers(arrays, f"{kind}_log_error"), inputs, odd)
    error = np.sqrt(arrays[f"{kind}_error"] ** 2 @ parts**2)
    falls = 1.0 / (1.0 + np.exp(-evaluate(select_layers(arrays, f"{kind}_falls"), inputs)[..., 0].mean(axis=0)))
    return Speeds(values.mean(axis=0), error, prints, falls, values)
