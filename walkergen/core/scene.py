"""Scene: the drive, the contact between foot and plate, and how both are simulated."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, cast, get_args

from pydantic import BeforeValidator, Field, model_validator

from walkergen.core.drive import GRAVITY as GRAVITY
from walkergen.core.drive import REST_GAMMA as REST_GAMMA
from walkergen.core.drive import Drive as Drive
from walkergen.core.drive import still_plate_drive as still_plate_drive
from walkergen.core.errors import InputError
from walkergen.core.files.assignments import replace_values
from walkergen.core.files.config import Fraction, Friction, Name, Section

if TYPE_CHECKING:
    from walkergen.core.dish import Dish

MIN_RESTITUTION = 0.02
"""Least restitution of elastic feet and walls, whose dampers need a damping ratio of 3.5 for it."""


class Prior(NamedTuple):
    """Assumed numbers of a contact, for those that a scene does not give."""

    words: str
    restitution: float
    restitution_sd: float
    friction: float
    friction_sd: float
    tip_radius_sd_factor: float
    """Standard deviation of the effective radius of the foot's tips, as a factor."""


PAPER_CONTACT = Prior("contact of the paper's plate", 0.8, 0.1, 0.25, 0.02, 2.0)
"""Restitution and friction as the paper measured them on its plate. The tips' radius is inferred from its walkers'
60 mm/s at 10 deg (evidence/tables/contact.py)."""

UNKNOWN_CONTACT = Prior("unknown plastic on an unknown plate", 0.70, 0.12, 0.25, 0.08, 3.0)
"""Any printed plastic on any plate: restitution 0.5 to 0.9 and friction 0.1 to 0.4 are about two standard deviations to
either side. Measured ones lie between: the paper's 0.8 and 0.25, and 0.87 and 0.25 of spheres of cellulose acetate
(Foerster et al., Physics of Fluids 6, 1994, 1108). That others lie in these ranges is assumed."""

PRIORS = {"paper": PAPER_CONTACT, "unknown": UNKNOWN_CONTACT}


class Contact(Section):
    """Contact of foot and plate: restitution and friction, with their standard deviations.

    Numbers that are not given are those of the prior; a friction that is given as 0 is exact.
    """

    prior: Literal["paper", "unknown"] = "paper"
    """Source of the numbers below that are not given: the paper's plate, or any plastic on any plate."""
    restitution: Fraction = PAPER_CONTACT.restitution
    """Coefficient of restitution of foot and plate."""
    restitution_sd: Fraction = PAPER_CONTACT.restitution_sd
    """Standard deviation of the restitution, for bounds."""
    friction: Friction = PAPER_CONTACT.friction
    """Coefficient of friction of foot and plate."""
    friction_sd: Friction = PAPER_CONTACT.friction_sd
    """Standard deviation of the friction, for bounds."""

    @model_validator(mode="after")
    def _fill_from_prior(self) -> "Contact":
        """Set numbers that are not given to the prior's. They still count as not given: another prior replaces them."""
        numbers = PRIORS[self.prior]._asdict()
        del numbers["words"], numbers["tip_radius_sd_factor"]
        if self.friction == 0.0 and "friction" in self.model_fields_set:
            numbers["friction_sd"] = 0.0  # a limit and no measurement: nothing scatters about it
        self.__dict__.update({k: v for k, v in numbers.items() if k not in self.model_fields_set})
        return self

    @property
    def origin(self) -> str:
        """Words on where the numbers come from, such as "contact as given"."""
        prior = PRIORS[self.prior].words
        named = [name for name in ("restitution", "friction") if {name, f"{name}_sd"} & self.model_fields_set]
        if not named:
            return prior
        return "contact as given" if len(named) == 2 else f"{named[0]} as given, else {prior}"


Phase = Annotated[float, Field(ge=-360, le=360)]
Ratio = Annotated[float, Field(ge=0, le=100)]
Percent = Annotated[float, Field(ge=-100, le=100)]
NoiseHz = Annotated[float, Field(ge=1e-6, le=5_000)]
PAIR = Field(min_length=2, max_length=2)
"""Length of a list of two numbers."""


class Elastic(NamedTuple):
    """Elastic constants of a plate's material."""

    youngs_modulus_gpa: float
    poisson_ratio: float


PLATE_MATERIALS = {
    "acrylic": Elastic(3.2, 0.37),
    "glass": Elastic(70.0, 0.22),
    "aluminium": Elastic(70.0, 0.33),
    "steel": Elastic(200.0, 0.29),
}


class Plate(Section):
    """Material, slope and faults of the shaken plate."""

    removed_keys: ClassVar[Mapping[str, str]] = {
        "poisson_ratio": "It follows from the material: write material = 'glass', 'acrylic', 'aluminium' or 'steel'.",
        **dict.fromkeys(("noise_low_hz", "noise_high_hz"), "Write noise_band_hz = [20, 400]."),
        **dict.fromkeys(("along_ratio", "across_ratio"), "Write horizontal_ratio = [along x, left]."),
        **dict.fromkeys(("along_phase_deg", "across_phase_deg"), "Write horizontal_phase_deg = [along x, left]."),
        "gradient_toward_deg": "Write gradient_percent_per_mm = [along x, left].",
        "rocking_toward_deg": "Write rocking_percent_per_mm = [along x, left].",
    }

    material: Literal["acrylic", "glass", "aluminium", "steel"] = "acrylic"
    """Material of the plate, which gives its elastic constants."""
    youngs_modulus_gpa: Annotated[float, Field(ge=1e-6, le=1e4)] | None = None
    """Young's modulus of the plate. None: that of the material."""
    slope_deg: Annotated[float, Field(gt=-60, lt=60)] = 0.0
    """Descent of the plate toward +x, deg: a positive slope helps the walker along."""
    noise_ratio: Annotated[float, Field(ge=0, le=100)] = 0.0
    """Root mean square of the plate's random velocity over the drive's peak speed."""
    noise_band_hz: Annotated[list[NoiseHz], PAIR] = Field(default=[20.0, 400.0])
    """Lowest and highest frequency of the noise, between which its velocity has an even spectrum."""
    roughness_um: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    """Root mean square height of the plate's bumps."""
    roughness_length_mm: Annotated[float, Field(ge=1e-3, le=1e6)] = 1.0
    """Wavelength of the bumps."""
    horizontal_ratio: Annotated[list[Ratio], PAIR] = Field(default=[0.0, 0.0])
    """Amplitudes of the plate's horizontal motion over the drive's amplitude, along x and to the left of x."""
    horizontal_phase_deg: Annotated[list[Phase], PAIR] = Field(default=[0.0, 0.0])
    """Phase leads of the two horizontal motions over the drive."""
    gradient_percent_per_mm: Annotated[list[Percent], PAIR] = Field(default=[0.0, 0.0])
    """Growth of the drive's amplitude with distance from the walker's starting point, along x and to the left of x."""
    rocking_percent_per_mm: Annotated[list[Percent], PAIR] = Field(default=[0.0, 0.0])
    """Rocking of the plate about the starting point, a quarter of a period ahead of the drive: amplitude of the height
    over the drive's amplitude, for each mm from that point, along x and to the left of x."""

    @model_validator(mode="after")
    def _check_noise_band(self) -> "Plate":
        low, high = self.noise_band_hz
        if not low < high:
            raise ValueError(f"noise_band_hz = [{low:g}, {high:g}]: the first must lie below the second: exchange them")
        return self

    @property
    def elastic(self) -> Elastic:
        """Elastic constants of the plate's material, with `youngs_modulus_gpa` in place of its modulus if given."""
        elastic, modulus = PLATE_MATERIALS[self.material], self.youngs_modulus_gpa
        return elastic if modulus is None else elastic._replace(youngs_modulus_gpa=modulus)

    @property
    def sways(self) -> bool:
        """Whether the plate moves horizontally, or its points move by different heights."""
        return any((*self.horizontal_ratio, *self.gradient_percent_per_mm, *self.rocking_percent_per_mm))


class Arena(Section):
    """Ground of the walker: a lane between walls or a plane, under a lid or open."""

    kind: Literal["lane", "plane"] = "lane"
    """Lane along x between walls, or a plane."""
    length_mm: Annotated[float, Field(ge=1e-3, le=1e9)] | None = None
    """Length of the ground, mm. Walkers start in its middle, and runs end at its ends. None: endless."""
    width_mm: Annotated[float, Field(ge=1e-3, le=1e9)] | None = None
    """Width of a plane, mm. Walkers start in its middle. None: endless."""
    gap_mm: Annotated[float, Field(ge=1e-3, le=1e6)] | None = None
    """Distance between a lane's walls, mm. None: the walker's depth plus 0.5 mm."""
    lid_mm: Annotated[float, Field(ge=1e-3, le=1e6)] | None = None
    """Height of a lid over the plate, mm. It moves with the plate, and bodies touch it. None: open."""
    wall_friction: Friction = 0.25
    """Friction of the body on walls and lid."""
    wall_restitution: Annotated[float, Field(ge=MIN_RESTITUTION, le=1)] = 0.5
    """Restitution of the body on walls and lid."""

    @model_validator(mode="after")
    def _check_size_keys(self) -> "Arena":
        wrong = "width_mm" if self.kind == "lane" else "gap_mm"
        if getattr(self, wrong) is not None:
            raise ValueError(
                f"{wrong} = {getattr(self, wrong):g}: a {self.kind} has no such size. Give "
                + ("gap_mm" if self.kind == "lane" else "width_mm")
            )
        return self


class Crowd(Section):
    """Many walkers in a dish: their number, the dish, and the contact of their bodies."""

    count: Annotated[int, Field(ge=1, le=100_000)] | None = None
    """Number of walkers. None: from `packing`, or 10."""
    packing: Annotated[float, Field(gt=0, le=0.9)] | None = None
    """Area of the walkers' outlines over the area of the dish."""
    arena_mm: str = "disc:120"
    """The dish: disc:DIAMETER, ring:OUTER,INNER, rectangle:LENGTHxWIDTH or periodic:SIDE, mm."""
    restitution: Annotated[float, Field(ge=MIN_RESTITUTION, le=1)] = 0.5
    """Restitution between bodies. For walls see `arena.wall_restitution`."""
    friction: Friction = 0.3
    """Friction between bodies. For walls see `arena.wall_friction`."""

    @model_validator(mode="after")
    def _check_count_and_dish(self) -> "Crowd":
        if self.count is not None and self.packing is not None:
            raise ValueError("count and packing both set the number of walkers: keep one of them")
        if "arena_mm" in self.model_fields_set:
            from walkergen.core import dish

            try:
                dish.parse_dish(self.arena_mm, "arena_mm")
            except InputError as error:
                raise ValueError(str(error)) from None
        return self

    @property
    def dish(self) -> "Dish":
        """Dish of the crowd, parsed from `arena_mm`."""
        from walkergen.core import dish

        return dish.parse_dish(self.arena_mm, "crowd.arena_mm")


class LegModel(Section):
    """Damping of the legs in the simulation."""

    damping_ratio: Annotated[float, Field(ge=0, le=10)] = 0.05
    """Damping ratio of a free leg on a held body."""
    damping_ratio_sd: Annotated[float, Field(ge=0, le=10)] = 0.02
    """Standard deviation of the damping ratio, for bounds."""


class Feet(Section):
    """Elastic feet: each corner of a foot is a small elastic sphere (*tip*), in series with the spring of the leg."""

    removed_keys: ClassVar[Mapping[str, str]] = {
        "damping": "Feet have one damper, which gives contact.restitution. Leave the key out.",
        "stiffness_ratio": "A leg is as stiff as its material (material.youngs_modulus_gpa). Leave the key out.",
        "local_stiffness_ratio": "Write feet.tip_radius_um (5 by default), or feet.rigid_tips = true for rigid tips.",
    }

    tip_radius_um: Annotated[float, Field(ge=1e-3, le=1e6)] = 5.0
    """Effective radius of a tip: a smooth sphere of this radius is as stiff as the corner of a rough printed foot."""
    tip_radius_sd_factor: Annotated[float, Field(ge=1, le=100)] | None = None
    """Standard deviation of `tip_radius_um` as a factor, log-normal, for bounds. None: from `contact.prior`."""
    rigid_tips: bool = False
    """True: tips are rigid and only legs are elastic, as if `tip_radius_um` were infinite."""
    tangential_ratio: Annotated[float, Field(ge=1e-6, le=1e3)] = 0.8
    """Tangential over normal stiffness of a tip's contact (Mindlin: 0.8 for equal materials)."""
    unevenness_um: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    """Standard deviation of the heights of the feet's corners. Every run draws new ones, as another print has."""
    unevenness_sd_um: Annotated[float, Field(ge=0, le=1e6)] = 5.0
    """Standard deviation of `unevenness_um` between printed copies, for bounds. Negative draws become positive."""


def _parse_headings(value: Any) -> Any:
    """Return headings (deg, a number or several) as a tuple, or "uniform" unchanged. Raises ValueError for others."""
    listed = value if isinstance(value, (list, tuple)) else (value,)
    are_valid = all(
        isinstance(entry, (int, float)) and not isinstance(entry, bool) and abs(entry) <= 360 for entry in listed
    )
    if value != "uniform" and not (are_valid and listed):
        raise ValueError('must be one or several numbers in -360..360 deg, such as [0, 90, 180, 270], or "uniform"')
    return value if value == "uniform" else tuple(listed)


class Run(Section):
    """Duration, number and step of the simulated runs."""

    seconds: Annotated[float, Field(ge=1e-8, le=1e7)] = 60.0
    """Measured time of one run, s, after `discard_seconds`."""
    discard_seconds: Annotated[float, Field(ge=0, le=1e7)] = 1.0
    """Time at the beginning of every run that is not measured, s."""
    runs: Annotated[int, Field(ge=1, le=100_000)] = 16
    """Number of runs. Each begins with another drop of the walker, at another phase of the plate."""
    seed: Annotated[int, Field(ge=0, le=2**63)] = 1
    """Seed of all random numbers."""
    heading_deg: Annotated[tuple[float, ...] | Literal["uniform"], BeforeValidator(_parse_headings)] = (0.0,)
    """Headings at the start of the runs, counted from x to the left and taken in turn. "uniform": random ones."""
    step_us: Annotated[float, Field(ge=0.01, le=1000)] | None = None
    """Time step, us, while a foot is in contact. None: small enough to resolve the feet."""
    accepted_error: Annotated[float, Field(ge=1e-6, le=10)] | None = None
    """Accepted error of the mean speed, as a share. Each effect ([effects]) is measured, and left out if it changes the
    speed by less than this share. Effects in `effects.on` stay. None: no effect is left out. Predictions from simulated
    runs do the same, and their bounds include the change."""


EffectName = Literal[
    "second_harmonic",
    "plate_slope",
    "air_drag",
    "roll_and_yaw",
    "leg_twist",
    "lane_walls",
    "lid",
    "unevenness",
    "plate_noise",
    "plate_along",
    "plate_gradient",
    "plate_rocking",
    "plate_roughness",
    "gyroscopic_torque",
]
"""Effects that a scene may force on or off."""


def forced_effect_line(name: str, on: bool) -> str:
    """Return the line of a scene's file that forces the effect `name` on or off, such as effects.on = ["lid"]."""
    return f'effects.{"on" if on else "off"} = ["{name}"]'


class Effects(Section):
    """Effects (parts of the physics, such as air drag) to force on or off. Otherwise the other keys decide."""

    removed_keys: ClassVar[Mapping[str, str]] = {
        name: f"Write {forced_effect_line(name, False)} for false, {forced_effect_line(name, True)} for true."
        for name in get_args(EffectName)
    }

    on: list[EffectName] = Field(default=[])
    """Effects to simulate although the other keys do not require them."""
    off: list[EffectName] = Field(default=[])
    """Effects to leave out although the other keys require them."""

    @model_validator(mode="after")
    def _check_both(self) -> "Effects":
        if both := [name for name in self.on if name in self.off]:
            raise ValueError(f"{', '.join(both)}: in effects.on and in effects.off. Remove it from one of them")
        return self

    def forced_state(self, name: str) -> bool | None:
        """Return True for an effect that is forced on, False for one forced off, else None."""
        return True if name in self.on else False if name in self.off else None

    def force(self, name: str, state: bool | None) -> "Effects":
        """Return a copy in which an effect is forced on (`state` True), off (False) or left to the scene (None)."""
        on, off = ([other for other in names if other != name] for names in (self.on, self.off))
        if state is not None:
            (on if state else off).append(cast(EffectName, name))
        return self.model_copy(update={"on": on, "off": off})


class Prediction(Section):
    """Further assumptions of predicted speeds."""

    model_sd: Annotated[float, Field(ge=0, le=3)] = 0.10
    """Standard deviation of the simulation's own error, as a share of the speed. The default covers the change under
    other reasonable choices in the model (docs/physics.md section 4)."""
    impact_speed_factor: Annotated[float, Field(ge=1e-6, le=1000)] = 0.45
    """For the theory, the paper's formula: speed at which a foot hits the plate over the plate's peak speed. With 0.45
    and the paper's restitution and friction it gives the paper's 60 mm/s at 10 degrees."""


DEPENDENT_KEYS: Mapping[str, tuple[str, ...]] = {
    "drive.second_harmonic_ratio": ("drive.second_harmonic_phase_deg",),
    "plate.noise_ratio": ("plate.noise_band_hz",),
    "plate.roughness_um": ("plate.roughness_length_mm",),
    "plate.horizontal_ratio": ("plate.horizontal_phase_deg",),
}
"""Numbers of a scene, and the keys that have a meaning only if the number is not zero."""


class Scene(Section):
    """Everything outside the walker: drive, contact, plate and the settings of simulations.

    Arguments are the tables and keys of a scene's file, as ``drive={"gamma": 2.0}``. Names state the units.

    Raises
    ------
    pydantic.ValidationError
        If a key is unknown or a value is outside its range.

    Examples
    --------
    >>> from walkergen.core import Scene
    >>> scene = Scene(drive={"frequency_hz": 90.0, "gamma": 2.0})
    >>> round(scene.drive.peak_speed, 1)  # mm/s
    34.7
    """

    name: Name = "scene"
    description: Annotated[str, Field(max_length=2000)] = ""
    drive: Drive = Drive(frequency_hz=90.0, gamma=1.8)
    contact: Contact = Contact()
    prediction: Prediction = Prediction()
    plate: Plate = Plate()
    arena: Arena = Arena()
    crowd: Crowd = Crowd()
    legs: LegModel = LegModel()
    feet: Feet = Feet()
    run: Run = Run()
    effects: Effects = Effects()

    def adjust_other_keys(self, data: dict[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the tables of this scene after `values` were set, without keys of the drive that contradict these.

        Parameters
        ----------
        data : dict
            Tables of the scene's file, which are changed in place.
        values : mapping
            Values that were set, by dotted keys.

        Returns
        -------
        dict
            The same data.
        """
        keys = {key.removeprefix("drive."): values[key] for key in values if key.startswith("drive.")}
        if keys and isinstance(data.get("drive"), dict):
            data["drive"] = self.drive.drop_contradicted_keys(data["drive"], keys)
        return data

    def variant(self, **keys: Any) -> "Scene":
        """Return a copy of the scene in which some keys have other values.

        The copy is validated as a file is, unlike a copy by pydantic's `model_copy`.

        Parameters
        ----------
        **keys : Any
            Values by dotted keys.

        Returns
        -------
        Scene
            The variant; this scene is unchanged.

        Raises
        ------
        InputError
            If a key is unknown or has an invalid value. The message has a line for each.

        Examples
        --------
        >>> import walkergen as wg
        >>> wg.load("lane-90hz").variant(**{"drive.gamma": 2.0}).value("drive.gamma")
        2.0
        """
        return replace_values(self, keys, self.name)

    def value(self, key: str) -> Any:
        """Return the value of one of the scene's keys.

        Parameters
        ----------
        key : str
            Table and key, as "drive.gamma".

        Returns
        -------
        Any
            The value; the default if the file does not have the key.
        """
        table, _, name = key.partition(".")
        return getattr(getattr(self, table), name)

    def is_zero(self, key: str) -> bool:
        """Return whether the value of a key is zero, a list of zeros, or not given.

        Parameters
        ----------
        key : str
            Table and key, as "plate.horizontal_ratio".

        Returns
        -------
        bool
            True if the value has no number other than zero.
        """
        value = self.value(key)
        return not (any(value) if isinstance(value, list) else value)
