"""Requests: what a job is asked for. Its command and its function for Python are made of the fields.

A field has a type, a default, limits and a `Flag`, which has the help. Its validator reads what a shell gives, a text,
and what Python gives; an error about a value names its field. Options that several requests share are here.
"""

import errno
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, PrivateAttr, ValidationError, field_validator

from walkergen import inputs
from walkergen.command_table import for_call, for_shell
from walkergen.core.errors import InputError
from walkergen.core.files import assignments, config, file_reading, formatting, safe_text
from walkergen.core.files.progress import Expect, Progress, ignore_estimate

if TYPE_CHECKING:
    from walkergen.core.walker.design import Design
    from walkergen.files.report import Report

PAPER_WALKER, LANE_SCENE, PLANE_SCENE, TABLE_SCENE, DEFAULT_PRINTER = (
    "koumakis2016",
    "lane-90hz",
    "plane-90hz",
    "table-motor",
    "prusa-mk3s",
)
"""Templates of the walker, the scenes and the printer that requests begin with."""

MAX_TILT_DEG, MAX_TILTS, MAX_BUDGET_S = 85, 10_000, 86_400.0
"""Largest tilt (deg), most tilts of a request, longest budget of time (s)."""


VALUE_FORMS = {
    "int_type": "must be a whole number",
    "float_type": "must be a number",
    "finite_number": "must be a number",
    "missing": "is missing",
}
"""Forms of a value in words, by pydantic's names of the mistake of another."""


class Flag(NamedTuple):
    """How people meet a field: in a shell as an option, in Python as an argument of the field's name."""

    help: str
    metavar: str = ""
    """What stands for the value in a help; for "" none does, as of a yes."""
    name: str = ""
    """Flag, where it is not the field's name with dashes."""
    takes: str = ""
    """Type of what Python gives, where it is wider than the field's."""
    sets: str = ""
    """Key of a file that the field sets."""
    templates: tuple[str, ...] = ()
    """Kinds of templates whose names the shell completes."""
    argument: bool = False
    """True where the shell gives it without a flag."""
    repeats: bool = False
    """True where the shell may give it several times."""


FILE_PLACEHOLDERS = {"walkers": ("DESIGN", "Walker"), "scenes": ("SCENE", "Ground"), "printers": ("PRINTER", "Machine")}
"""Placeholder and type of what is read from a template or a file, by the kind of templates."""


def file_flag(kind: str, help: str, name: str = "", optional: bool = False, argument: bool = False) -> Flag:
    """Flag of a walker, a scene or a printer; Python may leave an `optional` one None."""
    metavar, takes = FILE_PLACEHOLDERS[kind]
    return Flag(help, metavar, name, f"{takes} | None" if optional else takes, templates=(kind,), argument=argument)


class Request(BaseModel):
    """What a job is asked for."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    by_position: ClassVar[tuple[str, ...]] = ("design", "scene")
    """Fields that Python may give without their names."""

    _shell: bool = PrivateAttr(False)
    """True where a command asks."""

    _expect: Expect = PrivateAttr(default_factory=lambda: ignore_estimate)

    _notes: list[str] = PrivateAttr(default_factory=list)
    """What a person should know of what was read, a line each."""

    @field_validator("*", mode="before")
    @classmethod
    def _to_python(cls, value: Any) -> Any:
        """Convert a NumPy scalar to a Python number."""
        return value.item() if type(value).__module__ == "numpy" and not value.shape else value

    @classmethod
    def from_values(cls, values: Mapping[str, Any], shell: bool = False) -> Self:
        """Request of these values, of a command or of Python.

        Raises InputError, a line for every value that means nothing.
        """
        try:
            request = cls.model_validate(values)
        except ValidationError as error:
            lines = {_format_mistake(cls, mistake): str(mistake["loc"][0]) for mistake in error.errors()}
            raise InputError("\n".join(lines), *lines.values()) from None
        request._shell = shell
        return request

    @classmethod
    def to_flags(cls, text: str) -> str:
        """Return a text whose fields are the flags of the request's command."""
        return for_shell(text, {field: flag_name(cls, field) for field in cls.model_fields})

    @classmethod
    def to_arguments(cls, text: str, given: Iterable[str] = ()) -> str:
        """Return a text whose fields are Python's arguments, also of keys that the given ones set."""
        return for_call(text, {key: name for name in given if (key := field_flag(cls, name).sets)})

    reports: ClassVar[bool] = True
    """False of a job that has no report: a server."""

    def run(self, progress: Progress) -> "Report | None":
        """Do the job. Raises WalkergenError."""
        raise NotImplementedError

    def output_folder(self, default: Path) -> Path | None:
        """Folder to write to: a command has a default one, a function of Python writes where it is told to."""
        return getattr(self, "out", None) or (default if self._shell else None)

    def register_time_callback(self, expect: Expect) -> None:
        """Have somebody told how long the job will take, as soon as it knows."""
        self._expect = expect

    def inputs(self, more: Mapping[str, tuple[str, Any]] = MappingProxyType({})) -> inputs.Inputs:
        """Values that fields and --set give to keys of the design, and of the scene and printer that it has.

        So do flags with `more` values, by keys.
        """
        fields = dict(more)
        for name in type(self).model_fields:
            value = getattr(self, name)
            if (key := field_flag(type(self), name).sets) and value is not None:
                fields[key] = name, value
        things = [thing for thing in ("design", "scene", "printer") if thing in type(self).model_fields]
        own = inputs.from_settings(getattr(self, "set", {}), fields, things)
        return own._replace(notes=self._notes, asks=self._shell)

    @property
    def notes(self) -> list[str]:
        """What a person should know of what was read, once the job is done, a line each."""
        return self._notes

    def check_unset(self, why: str, *fields: str) -> None:
        """Raise InputError for the first of some fields that is not as it is by default."""
        for name in fields:
            value = getattr(self, name)
            if value != type(self).model_fields[name].get_default(call_default_factory=True):
                seen = f"‹{name}›" if value is True else f"‹{name}=›{safe_text.shorten_line(str(value))[:60]}"
                raise InputError(f"{seen}: {why}; leave it out", name)


def field_flag(request: type[Request], name: str) -> Flag:
    """How people meet a field."""
    return next(item for item in request.model_fields[name].metadata if isinstance(item, Flag))


def flag_name(request: type[Request], name: str) -> str:
    """Field as a command line names it."""
    own = field_flag(request, name)
    return own.metavar.partition(".")[0] if own.argument else own.name or "--" + name.replace("_", "-")


def _format_mistake(request: type[Request], mistake: Any) -> str:
    """Line on a mistake of pydantic's: flag, value seen, what is allowed."""
    name, kind, value = str(mistake["loc"][0]), mistake["type"], mistake["input"]
    if kind == "value_error":
        rule = mistake["msg"].removeprefix("Value error, ")
    else:
        of_field = config.describe_allowed_values((name,), request)  # type: ignore[arg-type]  # it reads the fields alone
        rule = ((VALUE_FORMS | config.TYPE_RULES).get(kind) or of_field or mistake["msg"]).replace("'", "")
    shown = safe_text.shorten_line(repr(value) if isinstance(value, str) else str(value))[:60]
    return f"‹{name}=›{shown}: {rule}"


def parse_number(text: object) -> float:
    """Parse a number if it is a text."""
    value = formatting.parse_number(text) if isinstance(text, str) else text
    if value is None or isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{str(text)[:30]!r} is not a number")
    return float(value) + 0.0


def parse_tilt(text: object) -> float:
    """Tilt, deg, of a text, or as it is."""
    value = parse_number(text)
    if not -MAX_TILT_DEG <= value <= MAX_TILT_DEG:
        raise ValueError(f"{str(text)[:30]} must lie in -{MAX_TILT_DEG}..{MAX_TILT_DEG} deg")
    return value


def split_values(value: Any) -> list[Any]:
    """Entries of a text with commas, of anything with several values, or of a single one."""
    if isinstance(value, str):
        return [word.strip() for word in value.split(",")]
    try:
        return list(value)
    except TypeError:  # a single value, or an array of no dimension
        return [value]


def choose_scene(scene: Any, designs: Sequence["Design"], usual: str = LANE_SCENE) -> Any:
    """Return the given scene, or the template for these walkers: a table if one has a motor of its own."""
    if scene is not None:
        return scene
    return TABLE_SCENE if any(design.motor is not None for design in designs) else usual


def parse_tilts(value: Any) -> list[float] | None:
    """Tilts in degrees of a text: 10, or 5,10,15, or FIRST:LAST:STEP with both ends; or as they are."""
    if value is None:
        return None
    tilts: list[float] = []
    for piece in split_values(value):
        numbers = [parse_tilt(word) for word in (piece.split(":") if isinstance(piece, str) else [piece])]
        if len(numbers) not in (1, 3):
            raise ValueError("write 10, or 5,10,15, or FIRST:LAST:STEP")
        tilts += numbers if len(numbers) == 1 else _tilt_range(*numbers)
    unique = list(dict.fromkeys(tilts))
    if len(unique) > MAX_TILTS:
        raise ValueError(f"{len(unique)} tilts; at most {MAX_TILTS}")
    return unique


def _tilt_range(first: float, last: float, step: float) -> list[float]:
    if step == 0 or (last - first) / step < 0:
        raise ValueError(f"step {step:g} does not lead from first to last")
    count = (last - first) / step
    if count > MAX_TILTS:
        raise ValueError(f"more than {MAX_TILTS} tilts; take a larger step")
    # Rounded to what people write, so that 0:1:0.1 gives 0.3 and not 0.30000000000000004.
    return [round(first + index * step, 9) + 0.0 for index in range(int(count + 1e-9) + 1)]


def _parse_kinds(value: Any) -> list[Any] | None:
    return None if value is None else list(dict.fromkeys(split_values(value)))


def parse_settings(value: Any) -> dict[str, Any]:
    """Values by keys, of KEY=VALUE each, or as they are. Raises InputError, or ValueError for what is neither."""
    if isinstance(value, Mapping):
        return dict(value)
    settings: dict[str, Any] = {}
    for text in parse_texts(value):
        key, word = assignments.split_key_value(text)
        new = assignments.parse_value(word)
        if key in settings and repr(settings[key]) != repr(new):
            raise InputError(f"‹set› {key[:60]}: given twice: leave one of them out", key)
        settings[key] = new
    return settings


def parse_texts(value: Any) -> list[str]:
    """Texts KEY=VALUE, of one or several. Raises ValueError for what is none."""
    texts = [value] if isinstance(value, str) else split_values(() if value is None else value)
    if not all(isinstance(text, str) for text in texts):
        raise ValueError("must be texts KEY=VALUE, or a dict of values by keys")
    return texts


def parse_time(value: Any) -> float | None:
    """Seconds of a text with its unit, 60s, 5min, 5m or 1h, or of a number."""
    units = {"min": 60.0, "m": 60.0, "s": 1.0, "h": 3600.0}
    seconds = value
    if isinstance(value, str):
        unit = next((unit for unit in units if value.endswith(unit)), "")
        number = formatting.parse_number(value.removesuffix(unit))
        if not unit or number is None:
            raise ValueError("write a time with its unit: 60s, 5min, 1h")
        seconds = number * units[unit]
    if seconds is not None and not 1.0 <= parse_number(seconds) <= MAX_BUDGET_S:
        raise ValueError(f"must lie in 1s..{MAX_BUDGET_S / 3600:g}h")
    return None if seconds is None else float(seconds)


def parse_effects(value: Any) -> float | None:
    """Share of the speed of a text, auto:1%, or of a number."""
    if not isinstance(value, str):
        return value  # type: ignore[no-any-return]
    share = formatting.parse_number(value.removeprefix("auto:").removesuffix("%"))
    if share is None or not (value.startswith("auto:") and value.endswith("%")) or not 1e-4 <= share <= 100.0:
        raise ValueError("write auto:1%, a share of the speed in 0.0001..100 %")
    return 0.01 * share


def _parse_path(value: Any) -> Path | None:
    return Path(value) if isinstance(value, (str, os.PathLike)) else value


def _parse_target(value: Any) -> Path | None:
    """Path to write to. Raises ValueError for a name that could not be read again, OutputError where others are."""
    path = _parse_path(value)
    if isinstance(path, Path):
        if not file_reading.has_safe_name(path):
            raise ValueError("holds control characters; give another name")
        _check_writable(path)
    return path


def _check_writable(path: Path) -> None:
    """Raise OutputError where no file can be made: it is told before the work, and not after it."""
    from walkergen.core.files import output

    place = next((each for each in (path, *path.parents) if os.path.lexists(each)), path)
    reason = 0 if place.is_dir() or place == path else errno.ENOTDIR
    if place.is_dir() and not os.access(place, os.W_OK | os.X_OK):
        reason = errno.EACCES
    if reason:
        raise output.write_error(path, OSError(reason, os.strerror(reason)))


File = BeforeValidator(_parse_path)
"""Path of a file to read, as text or as it is."""
Target = BeforeValidator(_parse_target)
"""Path of a file or folder to write."""
AsText = BeforeValidator(lambda value: str(value) if isinstance(value, (int, float)) else value)
"""Text for which Python may give a number."""
Words = BeforeValidator(lambda value: None if value is None else split_values(value))
"""List for which the shell gives a text with commas."""

Kind = Literal["flexible", "braced"]
WALKER_HELP = "Walker: a template, TOML file, drawing, picture or mesh."
Walker = Annotated[Any, file_flag("walkers", WALKER_HELP, argument=True)]
Filmed = Annotated[Any, file_flag("walkers", WALKER_HELP, "--design")]
Text = Annotated[str | None, Flag("Letters as the walker's body: a name.", "WORD", sets="body.text")]
Mirror = Annotated[bool | None, Flag("Turn a shape round: what pointed back is the front.", sets="body.mirror")]
Ground = Annotated[Any, file_flag("scenes", "Scene: a template or a TOML file.")]
HOME_HELP = f"Scene: a template or a TOML file; without, {LANE_SCENE}, of a walker with a motor {TABLE_SCENE}."
Home = Annotated[Any, file_flag("scenes", HOME_HELP, optional=True)]
Machine = Annotated[Any, file_flag("printers", "Printer: a template or a TOML file.")]
Tilt = Annotated[float | None, Flag("Tilt of the legs.", "DEG")]
Legs = Annotated[Kind | None, Flag("Kind of legs: flexible or braced.", "KIND")]
Tilts = Annotated[
    list[float] | None,
    BeforeValidator(parse_tilts),
    Flag("Tilts, deg: 10, or 5,10,15, or FIRST:LAST:STEP.", "DEG", takes="float | Iterable[float] | str | None"),
]
Kinds = Annotated[
    list[Kind] | None,
    BeforeValidator(_parse_kinds),
    Flag(
        "Kinds of legs: flexible, braced, or flexible,braced.", "KIND", "--legs", takes="Kind | Iterable[Kind] | None"
    ),
]
Restitution = Annotated[
    float | None, Flag("Coefficient of restitution, 0..1.", "NUMBER", sets="scene.contact.restitution")
]
Friction = Annotated[float | None, Flag("Friction coefficient, >= 0.", "NUMBER", sets="scene.contact.friction")]
Gamma = Annotated[float | None, Flag("Peak acceleration over g.", "NUMBER", sets="scene.drive.gamma")]
Frequency = Annotated[float | None, Flag("Frequency of the drive, Hz.", "HZ", sets="scene.drive.frequency_hz")]
Mode = Annotated[Literal["coulomb", "paper"], Flag("Theory: coulomb (feet may stick) or paper (eq. 15).", "MODE")]
Seconds = Annotated[float | None, Flag("Measured time of each simulated run, s.", "S", sets="scene.run.seconds")]
Runs = Annotated[int | None, Flag("Number of simulated runs.", "N", sets="scene.run.runs")]
Seed = Annotated[int | None, Flag("Seed of the runs' random starts.", "N", sets="scene.run.seed")]
Step = Annotated[float | None, Flag("Time step.", "MICROSECONDS", sets="scene.run.step_us")]
Effects = Annotated[
    float | None,
    BeforeValidator(parse_effects),
    Flag(
        "Leave out effects that change the speed by less: auto:1%.",
        "auto:ERROR",
        takes="str | float | None",
        sets="scene.run.accepted_error",
    ),
]
Settings = Annotated[
    dict[str, Any],
    BeforeValidator(parse_settings),
    Flag(
        "Key of a file to change: legs.length_mm=9, scene.drive.gamma=2, printer.nozzle_mm=1.",
        "KEY=VALUE",
        takes="Mapping[str, Any]",
        repeats=True,
    ),
]
Weights = Annotated[
    Path | None, File, Flag("Masses from a balance: a filled weights.csv.", "FILE", takes="Name | None")
]
Predicted = Annotated[
    Literal["best", "known", "theory"],
    Flag(
        "Speeds by what knows them best; known: without runs of seconds; or theory (eq. 15) alone.", "MODEL", "--model"
    ),
]
Uncertain = Annotated[bool, Flag("Draw uncertain inputs; say what to measure next.")]
Workers = Annotated[int | None, Flag("Number of processes; all cores by default.", "N")]
Pictures = Annotated[bool, Flag("Draw the figures.")]
Out = Annotated[Path | None, Target, Flag("Folder to write to; out/NAME by default.", "FOLDER", takes="Name | None")]
