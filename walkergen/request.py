"""Requests: the job of a command, and of the Python function with the same name.

Both are made from the fields. A field has a type, a default, limits and a `Flag` with its help. Errors about a value
name its field. Fields that several requests share are defined here.
"""

from collections.abc import Iterable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, PrivateAttr, ValidationError, field_validator

from walkergen import field_values, inputs
from walkergen.command_table import for_call, for_shell
from walkergen.core.errors import InputError
from walkergen.core.files import config, safe_text
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
"""Templates of the default walker, scenes and printer."""

VALUE_RULES = {
    "int_type": "must be a whole number",
    "float_type": "must be a number",
    "finite_number": "must be a finite number",
    "missing": "is missing",
}
"""Rules for values, by pydantic's names of the errors."""


class Flag(NamedTuple):
    """Option of a field on the command line. In Python the field is an argument."""

    help: str
    metavar: str = ""
    """Placeholder shown in the help; empty for a switch."""
    name: str = ""
    """Name of the flag; by default the field's name with dashes."""
    takes: str = ""
    """Type of the argument in Python, if it is wider than the field's."""
    sets: str = ""
    """Key of a file that the field sets."""
    templates: tuple[str, ...] = ()
    """Kinds of templates whose names the shell completes."""
    argument: bool = False
    """Whether the command line takes it by position, without a flag."""
    repeats: bool = False
    """Whether the command line may contain it several times."""


FILE_PLACEHOLDERS = {"walkers": ("DESIGN", "Walker"), "scenes": ("SCENE", "Ground"), "printers": ("PRINTER", "Machine")}
"""Placeholder and type of a template or a file, by the kind of templates."""


def file_flag(kind: str, help: str, name: str = "", optional: bool = False, argument: bool = False) -> Flag:
    """Return the flag of a field that names a walker, scene or printer; in Python it may be None if `optional`."""
    metavar, takes = FILE_PLACEHOLDERS[kind]
    return Flag(help, metavar, name, f"{takes} | None" if optional else takes, templates=(kind,), argument=argument)


class Request(BaseModel):
    """Job of a command, with all its settings."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    by_position: ClassVar[tuple[str, ...]] = ("design", "scene")
    """Fields that Python may give by position."""

    reports: ClassVar[bool] = True
    """Whether the job returns a report; a server returns none."""

    _shell: bool = PrivateAttr(False)
    """Whether the request comes from the command line."""

    _expect: Expect = PrivateAttr(default_factory=lambda: ignore_estimate)

    _notes: list[str] = PrivateAttr(default_factory=list)

    @field_validator("*", mode="before")
    @classmethod
    def _to_python(cls, value: Any) -> Any:
        """Convert a NumPy scalar to a Python number."""
        return value.item() if type(value).__module__ == "numpy" and not value.shape else value

    @classmethod
    def from_values(cls, values: Mapping[str, Any], shell: bool = False) -> Self:
        """Return the request with these values by field. `shell`: True if they come from the command line.

        Raises InputError with a line for each invalid value, under its flag or argument.
        """
        try:
            request = cls.model_validate(values)
        except ValidationError as error:
            lines = {_format_error(cls, entry): str(entry["loc"][0]) for entry in error.errors()}
            raise InputError("\n".join(lines), *lines.values()) from None
        request._shell = shell
        return request

    @classmethod
    def to_flags(cls, text: str) -> str:
        """Replace fields such as ‹mm_per_px=› in a text by flags of the command."""
        return for_shell(text, {field: flag_name(cls, field) for field in cls.model_fields})

    @classmethod
    def to_arguments(cls, text: str, given: Iterable[str] = ()) -> str:
        """Replace fields in a text, and keys that the fields `given` set, by names of Python arguments."""
        return for_call(text, {key: name for name in given if (key := field_flag(cls, name).sets)})

    def run(self, progress: Progress) -> "Report | None":
        """Do the job and return its report. Raises WalkergenError."""
        report: Report | None = self.do_work(progress)
        return report

    def do_work(self, progress: Progress, *more: Any) -> Any:
        """Import the module `make` of the request's folder, call its `run(self, progress, *more)` and return that."""
        return import_module(f"{type(self).__module__.rpartition('.')[0]}.make").run(self, progress, *more)

    def output_folder(self, default: Path) -> Path | None:
        """Return the folder to write to: the field `out`, or on the command line the default; None without one."""
        return getattr(self, "out", None) or (default if self._shell else None)

    def register_time_callback(self, expect: Expect) -> None:
        """Register a callback for the expected run time."""
        self._expect = expect

    def inputs(self, more: Mapping[str, tuple[str, Any]] = MappingProxyType({})) -> inputs.Inputs:
        """Return the values by key that the request's fields, and its field `set`, give to design, scene and printer.

        `more`: further pairs (field name, value) by key.
        """
        fields = dict(more)
        for name in type(self).model_fields:
            value = getattr(self, name)
            if (key := field_flag(type(self), name).sets) and value is not None:
                fields[key] = name, value
        things = [thing for thing in ("design", "scene", "printer") if thing in type(self).model_fields]
        settings = inputs.from_settings(getattr(self, "set", {}), fields, things)
        return settings._replace(notes=self._notes, asks=self._shell)

    @property
    def notes(self) -> list[str]:
        """Notes on the files that the job read, a line each."""
        return self._notes

    def check_unset(self, problem: str, *fields: str) -> None:
        """Raise InputError with this problem for the first of the fields that differs from its default."""
        for name in fields:
            value = getattr(self, name)
            if value != type(self).model_fields[name].get_default(call_default_factory=True):
                pairs = value.items() if isinstance(value, Mapping) else ()
                text = ",".join(f"{key}={entry}" for key, entry in pairs) or (
                    ",".join(map(str, value)) if isinstance(value, list) else str(value)
                )
                shown = f"‹{name}›" if value is True else f"‹{name}=›{safe_text.shorten_line(text)[:60]}"
                raise InputError(f"{shown}: {problem}. Remove it.", name)


def field_flag(request: type[Request], name: str) -> Flag:
    """Return the `Flag` of a field of a request class."""
    return next(item for item in request.model_fields[name].metadata if isinstance(item, Flag))


def field_help(request: type[Request], name: str) -> str:
    """Return the help text of a field of a request class, with the limits of a number."""
    text, metadata = field_flag(request, name).help, request.model_fields[name].metadata
    low, high = (
        next((f"{getattr(item, bound):.6g}" for item in metadata if hasattr(item, bound)), "") for bound in ("ge", "le")
    )
    limits = f"{low}..{high}" if high else f"at least {low}"
    return f"{text.removesuffix('.')}; {limits}." if low else text


def flag_name(request: type[Request], name: str) -> str:
    """Return the flag that the command line has for a field, or the placeholder of an argument."""
    flag = field_flag(request, name)
    return flag.metavar.partition(".")[0] if flag.argument else flag.name or "--" + name.replace("_", "-")


def _format_error(request: type[Request], error: Any) -> str:
    """Format an entry of pydantic's errors: field, value, and the rule that the value breaks."""
    name, kind, value = str(error["loc"][0]), error["type"], error["input"]
    if kind == "value_error":
        rule = error["msg"].removeprefix("Value error, ").removeprefix(f"{value!r} ")
    else:
        allowed = config.describe_allowed_values((name,), request)  # type: ignore[arg-type]  # only its fields are read
        allowed = allowed or inputs.describe_allowed_values(field_flag(request, name).sets)
        rules = VALUE_RULES | config.TYPE_RULES
        found = rules.get(kind) if kind == "missing" else allowed or rules.get(kind)
        rule = str(found or error["msg"]).replace("'", "")
    shown = safe_text.shorten_line(repr(value) if isinstance(value, str) else str(value))[:60]
    return f"‹{name}=›{shown}: {rule}"


def choose_scene(scene: Any, designs: Sequence["Design"], usual: str = LANE_SCENE) -> Any:
    """Return the given scene; for None TABLE_SCENE if a walker has a motor, else `usual`."""
    if scene is not None:
        return scene
    return TABLE_SCENE if any(design.motor is not None for design in designs) else usual


File = BeforeValidator(field_values.parse_path)
"""Path of a file to read."""
Target = BeforeValidator(field_values.parse_target)
"""Path of a file or folder to write."""
AsText = BeforeValidator(lambda value: str(value) if isinstance(value, (int, float)) else value)
"""Text, or a number in Python."""
Words = BeforeValidator(lambda value: None if value is None else field_values.split_values(value))
"""List, or comma-separated text."""

Kind = Literal["flexible", "braced"]
WALKER_HELP = "Walker: a template, TOML file, drawing, picture or mesh."
Walker = Annotated[Any, file_flag("walkers", WALKER_HELP, argument=True)]
Filmed = Annotated[Any, file_flag("walkers", WALKER_HELP, "--design")]
Text = Annotated[str | None, Flag("Make the body from letters, such as a name.", "WORD", sets="body.text")]
Mirror = Annotated[bool | None, Flag("Mirror the shape: its back becomes its front.", sets="body.mirror")]
Ground = Annotated[Any, file_flag("scenes", "Scene: a template or a TOML file.")]
HOME_HELP = f"Scene: a template or a TOML file. Default: {LANE_SCENE}, or {TABLE_SCENE} with a motor."
Home = Annotated[Any, file_flag("scenes", HOME_HELP, optional=True)]
Machine = Annotated[Any, file_flag("printers", "Printer: a template or a TOML file.")]
Tilt = Annotated[
    float | None,
    BeforeValidator(lambda value: None if value is None else field_values.parse_tilt(value)),
    Flag("Tilt of the legs, deg.", "DEG"),
]
Legs = Annotated[Kind | None, Flag("Kind of legs: flexible or braced.", "KIND")]
Tilts = Annotated[
    list[float] | None,
    BeforeValidator(field_values.parse_tilts),
    Flag("Tilts, deg: 10, or 5,10,15, or FIRST:LAST:STEP.", "DEG", takes="float | Iterable[float] | str | None"),
]
Kinds = Annotated[
    list[Kind] | None,
    BeforeValidator(field_values.parse_kinds),
    Flag(
        "Kinds of legs: flexible, braced, or flexible,braced.", "KIND", "--legs", takes="Kind | Iterable[Kind] | None"
    ),
]
Restitution = Annotated[
    float | None, Flag("Coefficient of restitution, 0..1.", "NUMBER", sets="scene.contact.restitution")
]
Friction = Annotated[float | None, Flag("Friction coefficient, >= 0.", "NUMBER", sets="scene.contact.friction")]
Gamma = Annotated[float | None, Flag("Peak acceleration of the plate over g.", "NUMBER", sets="scene.drive.gamma")]
Frequency = Annotated[float | None, Flag("Frequency of the drive, Hz.", "HZ", sets="scene.drive.frequency_hz")]
Mode = Annotated[Literal["coulomb", "paper"], Flag("Theory: coulomb (feet may stick) or paper (eq. 15).", "MODE")]
Seconds = Annotated[float | None, Flag("Measured time of each simulated run, s.", "S", sets="scene.run.seconds")]
Runs = Annotated[int | None, Flag("Number of simulated runs.", "N", sets="scene.run.runs")]
Seed = Annotated[int | None, Flag("Seed of the runs' random starts.", "N", sets="scene.run.seed")]
Step = Annotated[float | None, Flag("Time step, microseconds.", "MICROSECONDS", sets="scene.run.step_us")]
Effects = Annotated[
    float | None,
    BeforeValidator(field_values.parse_effects),
    Flag(
        "Drop effects that change the speed by less than this share, for example auto:1%.",
        "auto:ERROR",
        takes="str | float | None",
        sets="scene.run.accepted_error",
    ),
]
Settings = Annotated[
    dict[str, Any],
    BeforeValidator(field_values.parse_settings),
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
    Flag("Source of speeds: best, known (no simulation), or theory (eq. 15).", "MODEL", "--model"),
]
Uncertain = Annotated[bool, Flag("Vary the uncertain inputs, and report which one to measure next.")]
Workers = Annotated[int | None, Flag("Number of processes; all cores by default.", "N")]
Pictures = Annotated[bool, Flag("Draw the figures.")]
Out = Annotated[Path | None, Target, Flag("Folder to write to; out/NAME by default.", "FOLDER", takes="Name | None")]
