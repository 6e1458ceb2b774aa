"""Drive of a walker: a plate that is shaken, or a motor of its own with an unbalanced rotor.

The plate moves as A sin(omega t). Any two of frequency, amplitude, peak speed and gamma (peak
acceleration over g) determine it; a third and a fourth are accepted when they agree. A motor is
its frequency and the eccentric moment of its rotor; the plate is still (docs/physics.md section 8).
"""

import math
import re
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field, model_validator

from walkergen.core.errors import InputError
from walkergen.core.files.config import Section

GRAVITY = 9806.65
"""Standard gravity, mm/s^2."""

RELATIVE_TOLERANCE = 5e-3
"""Relative tolerance between redundant drive numbers: people write them to three digits."""

MAX_DERIVED_NUMBER = 1e12
"""Limit of the numbers of a drive that follow from others, each in its unit."""

Positive = Annotated[float, Field(ge=1e-6, le=1e9)]

MOTOR_FREQUENCY_RANGE_HZ = (1.0, 1000.0)
"""Frequencies (Hz) of motors: small ones turn at 50 to 300 Hz; steps in space resolve 1000."""

AXES = {"along": (1.0, 0.0, 0.0), "across": (0.0, -1.0, 0.0), "up": (0.0, 0.0, 1.0)}
"""Axes about which a rotor turns by the right hand, as components along, across (to the right) and
up: across its top moves forward, up it turns counter-clockwise seen from above."""

VIBRATION_KEYS = ("frequency_hz", "amplitude_um", "peak_speed_mm_s", "gamma")
"""Keys of a plate's vibration. Any two determine it."""

PLATE_KEYS = (*VIBRATION_KEYS[1:], "second_harmonic_ratio", "second_harmonic_phase_deg")
MOTOR_KEYS = ("eccentric_g_mm", "eccentric_sd_g_mm", "frequency_sd_hz", "axis")
"""Keys that only one kind of drive has."""

FOREIGN_QUANTITIES = (
    ("gamma", "peak acceleration in g", r"acc", {"g": 1.0, "m_s2": 1e3 / GRAVITY, "mm_s2": 1 / GRAVITY}),
    ("peak_speed_mm_s", "peak speed", r"vel|speed", {"mm_s": 1.0, "cm_s": 10.0, "m_s": 1e3, "um_s": 1e-3}),
    ("amplitude_um", "amplitude", r"ampl|disp|stroke|peak_?(to|2)|p2?p", {"um": 1.0, "nm": 1e-3, "mm": 1e3, "m": 1e6}),
)
"""For each quantity: its key, its meaning, a pattern of its names in other programs, and their units in our unit."""

FOREIGN_SHARES = {
    r"rms|eff": (math.sqrt(2.0), ", because the root mean square of a sine is 0.707 of its peak"),
    r"peak_?(to|2)?_?peak|pk_?pk|(^|_)p2?p(_|$)": (0.5, ", because peak to peak is twice that"),
}
"""Pattern of names of a part or multiple of a peak, the factor that gives the peak, and the reason."""


def _check_axis(value: Any) -> Any:
    """Return `value` unchanged if it is a name in AXES, three components, or None. Raises ValueError for others."""
    numbers = value if isinstance(value, list) and len(value) == 3 and any(value) else [math.nan]
    if all(isinstance(number, (int, float)) and abs(number) <= 1e3 for number in numbers) or value in (*AXES, None):
        return value
    raise ValueError('must be "along", "across", "up", or three numbers in -1000..1000, not all 0')


class Drive(Section):
    """Motion of a shaken plate, or a motor on the walker. Two of a plate's four numbers determine its vertical sine.

    A second harmonic may be added, given by its amplitude over that of the fundamental and by its phase; the four
    numbers remain those of the fundamental. A motor has a frequency and the moment of its rotor. The peak acceleration
    a on a mass m at a frequency f, as data sheets state it, is the moment m a/(2 pi f)^2.
    """

    removed_keys: ClassVar[Mapping[str, str]] = {
        "reversed": "Leave it out for false. For true, give the components of axis: [0, 1, 0] is across."
    }

    @classmethod
    def translate_key(cls, key: str) -> str:
        """Return advice on how to state here what other programs call `key`, such as "accel_g"; "" if unknown."""
        words = key.lower()
        if re.search(r"(^|_)dbu?(_|$)|decibel", words):
            return "A level in dB needs its reference: write gamma = 10^(dB / 20) times the reference's peak in g."
        for name, meaning, pattern, units in FOREIGN_QUANTITIES:
            if not re.search(pattern, words):
                continue
            unit = next((unit for unit in sorted(units, key=len)[::-1] if re.search(rf"_{unit}(_|$)", words)), "")
            share, reason = next((rule for part, rule in FOREIGN_SHARES.items() if re.search(part, words)), (1.0, ""))
            factor = share * units.get(unit, 1.0)
            value = "the same value" if factor == 1.0 else f"{factor:.4g} times that value"
            source = "" if unit else f", in {next(iter(units))}"
            return f"The key for the {meaning} is {name}: write {value}{source}{reason}."
        return ""

    kind: Literal["plate", "motor"] = "plate"
    """Source of the motion: a shaken plate, or a motor in each walker on a still plate."""
    frequency_hz: Positive | None = None
    """Frequency of the plate or of the motor. A plate needs two of this and the next three keys."""
    amplitude_um: Positive | None = None
    """Amplitude of the plate's displacement."""
    peak_speed_mm_s: Positive | None = None
    """Largest speed of the plate."""
    gamma: Positive | None = None
    """Largest acceleration of the plate, in units of gravity."""
    second_harmonic_ratio: Annotated[float, Field(ge=0, le=1)] = 0.0
    """Amplitude of the second harmonic over that of the fundamental."""
    second_harmonic_phase_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    """Phase shift of the second harmonic."""
    eccentric_g_mm: Annotated[float, Field(ge=1e-6, le=1e6)] | None = None
    """Unbalanced mass of the rotor times its distance from the axis."""
    eccentric_sd_g_mm: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    """Standard deviation of `eccentric_g_mm`, for bounds."""
    frequency_sd_hz: Annotated[float, Field(ge=0, le=1000)] = 0.0
    """Standard deviation of a motor's frequency, for bounds: batteries sag, and motors differ."""
    axis: Annotated[Literal["along", "across", "up"] | list[float] | None, BeforeValidator(_check_axis)] = None
    """Axis of the rotor: "along", "across" or "up", or components along these. None: the axis in the design."""

    @model_validator(mode="after")
    def _check_keys(self) -> "Drive":
        """Return the drive. Raises ValueError for keys of the other kind of drive, and for numbers that disagree."""
        others = MOTOR_KEYS if self.kind == "plate" else PLATE_KEYS
        for key in others:
            value = getattr(self, key)
            if value != type(self).model_fields[key].default:
                raise ValueError(
                    f"{key} = {value!r}: only a "
                    + (
                        "motor has this key, and kind is 'plate'. Set kind = 'motor'"
                        if self.kind == "plate"
                        else "shaken plate has this key, and kind is 'motor'. Leave it out, or use ‹scene=›lane-90hz"
                    )
                )
        return self._check_plate() if self.kind == "plate" else self._check_motor()

    def _check_motor(self) -> "Drive":
        """Return the drive. Raises ValueError for a motor with a wrong frequency, or without frequency or moment."""
        low, high = MOTOR_FREQUENCY_RANGE_HZ
        words = "none" if self.frequency_hz is None else f"{self.frequency_hz:g}"
        if self.frequency_hz is None or not low <= self.frequency_hz <= high:
            raise ValueError(
                f"frequency_hz = {words}: a motor's must lie in {low:g}..{high:g}; small ones turn at 50 to 300 Hz"
            )
        if self.eccentric_g_mm is None:
            raise ValueError(
                "eccentric_g_mm is missing: give a motor's unbalanced mass times its distance from the axis"
            )
        return self

    def _check_plate(self) -> "Drive":
        """Return the drive. Raises ValueError unless two or more numbers of a plate's vibration are given and agree."""
        numbers = self.model_dump(include=set(VIBRATION_KEYS), exclude_none=True)
        if len(numbers) < 2:
            raise ValueError(
                "give any two of frequency_hz, amplitude_um, peak_speed_mm_s, gamma; "
                f"seen: {', '.join(numbers) or 'none'}"
            )
        implied = {
            "frequency_hz": self.frequency,
            "amplitude_um": 1e3 * self.amplitude,
            "peak_speed_mm_s": self.peak_speed,
            "gamma": self.peak_gamma,
        }
        for key, value in numbers.items():
            if not math.isclose(value, implied[key], rel_tol=RELATIVE_TOLERANCE):
                first, second = list(numbers)[:2]
                raise ValueError(
                    f"{key} = {value:g} contradicts {first} and {second}, which give "
                    f"{implied[key]:.5g}. Remove one of them"
                )
        for key, value in implied.items():
            if not value <= MAX_DERIVED_NUMBER:
                raise ValueError(f"{' and '.join(numbers)} give {key} = {value:.3g}: must be <= {MAX_DERIVED_NUMBER:g}")
        return self

    def push_ratio(self, mass: float) -> float:
        """Return the centrifugal force of the motor's rotor over the weight of a walker of `mass` g; 0 for a plate."""
        return self.eccentric_moment * self.omega**2 / (mass * GRAVITY)

    @property
    def omega(self) -> float:
        """Angular frequency of the plate or the motor, rad/s."""
        if self.frequency_hz is not None:
            return 2 * math.pi * self.frequency_hz
        if self.amplitude_um is not None and self.peak_speed_mm_s is not None:
            return self.peak_speed_mm_s / (1e-3 * self.amplitude_um)
        assert self.gamma is not None
        if self.amplitude_um is not None:
            return math.sqrt(self.gamma * GRAVITY / (1e-3 * self.amplitude_um))
        assert self.peak_speed_mm_s is not None
        return self.gamma * GRAVITY / self.peak_speed_mm_s

    @property
    def frequency(self) -> float:
        """Frequency of the plate or the motor, Hz."""
        return self.omega / (2 * math.pi)

    @property
    def amplitude(self) -> float:
        """Amplitude of the plate's fundamental vibration, mm. Raises InputError for a motor."""
        if self.kind == "motor":
            raise InputError(
                "drive.kind = 'motor': how far a motor shakes depends on the walker that carries "
                "it; this needs the vibration of a plate: use a scene with drive.kind = 'plate'"
            )
        if self.amplitude_um is not None:
            return 1e-3 * self.amplitude_um
        if self.peak_speed_mm_s is not None:
            return self.peak_speed_mm_s / self.omega
        assert self.gamma is not None
        return self.gamma * GRAVITY / self.omega**2

    @property
    def peak_speed(self) -> float:
        """Largest speed of the plate's fundamental vibration, mm/s. Raises InputError for a motor."""
        return self.amplitude * self.omega

    @property
    def peak_gamma(self) -> float:
        """Largest acceleration of the plate's fundamental vibration over g. Raises InputError for a motor."""
        return self.peak_speed * self.omega / GRAVITY

    @property
    def eccentric_moment(self) -> float:
        """Unbalanced mass of a motor's rotor times its distance from the axis, g mm; 0 for a plate."""
        return self.eccentric_g_mm or 0.0

    def axis_vector(self, default_axis: str) -> tuple[float, float, float]:
        """Return the unit vector (along, across to the right, up) of a rotor's axis, by the right-hand rule.

        If the drive has no axis, it is `default_axis`: "along", "across" or "up".
        """
        axis = self.axis or default_axis
        x, y, z = AXES[axis] if isinstance(axis, str) else axis
        size = math.hypot(x, y, z)
        return x / size, y / size, z / size

    def equivalent_plate_drive(self, mass: float) -> "Drive":
        """Return the drive of a plate that moves as far as a free walker of `mass` g with this motor.

        Return a plate's drive unchanged.
        """
        if self.kind == "plate":
            return self
        return Drive.model_construct(frequency_hz=self.frequency_hz, amplitude_um=1e3 * self.eccentric_moment / mass)

    @property
    def motor_in_words(self) -> str:
        """Description of the motor, such as "motor, 170 Hz, 0.5 g mm, axis up"; "" for a plate."""
        if self.kind == "plate":
            return ""
        axis = f", axis {self.axis}" if self.axis else ""
        return f"motor, {self.frequency:g} Hz, {self.eccentric_moment:.3g} g mm{axis}"

    def drop_contradicted_keys(self, data: dict[str, Any], keys: Mapping[str, Any]) -> dict[str, Any]:
        """Return `data` without keys of this drive that contradict `keys`, the values that a user has just set.

        `data` has the values of all keys, the new ones included. Setting one of a plate's four numbers keeps the
        frequency. Setting the frequency keeps the peak acceleration, or a motor's moment.
        """
        if data.get("kind", "plate") == "motor":
            return self._drop_plate_keys(data, keys)
        if self.kind == "motor":
            data = {k: v for k, v in data.items() if k not in MOTOR_KEYS or k in keys}
        numbers = [key for key in VIBRATION_KEYS if key in keys]
        if numbers:
            data = {k: v for k, v in data.items() if k not in VIBRATION_KEYS or k in numbers}
            if numbers == ["frequency_hz"] and self.kind == "plate":
                data["gamma"] = self.gamma or self.peak_gamma
            elif len(numbers) == 1:
                data["frequency_hz"] = self.frequency_hz or self.frequency
        return data

    def _drop_plate_keys(self, data: dict[str, Any], keys: Mapping[str, Any]) -> dict[str, Any]:
        """Return a motor's `data`, without keys of a plate that are not in `keys`, but with this plate's frequency."""
        if self.kind == "plate":
            data = {k: v for k, v in data.items() if k not in PLATE_KEYS or k in keys}
            return {"frequency_hz": self.frequency} | data
        return data


REST_GAMMA = 1e-30
"""Peak acceleration over g of a plate at rest: its amplitude vanishes in the rounding of heights."""


def still_plate_drive(frequency_hz: float) -> Drive:
    """Return the drive of a plate at rest: its peak acceleration is REST_GAMMA, which a file may not have."""
    return Drive.model_construct(frequency_hz=frequency_hz, gamma=REST_GAMMA)
