"""Designs, scenes and printers that a request names: files or their contents, with changed keys.

All settings take one way: a flag of its own (--gamma) and --set scene.drive.gamma=2 both become a dotted key
with a value, and the file is read as if it contained them.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from walkergen.core.errors import COMMAND_LINE_SOURCE, InputError

if TYPE_CHECKING:
    from walkergen.core.files.config import Model
    from walkergen.core.printing.printers import Printer
    from walkergen.core.scene import Scene
    from walkergen.core.walker.design import Design
    from walkergen.core.walker.limbs import Kind
    from walkergen.core.walker.weighed_masses import Weighings
    from walkergen.points.worker_pool import WorkerPool

TILTS, KINDS = ("legs.tilt_deg", "leg_tilt_deg"), ("legs.kind",)
"""Keys of the tilt and the kind that the legs of a walker share, which --tilt and --legs set: of
two equal legs, and the tilt of a list of them."""

FAMILY_TILT_KEYS, FAMILY_KIND_KEYS = ("family.tilt_deg",), ("family.legs",)
"""Keys of a design that --tilt and --legs set of a whole family."""


class Inputs(NamedTuple):
    """Values that a request gives to keys of files."""

    values: Mapping[str, Any]
    """Values by dotted keys; those of a scene and a printer begin with these words."""
    fields: Mapping[str, str]
    """Fields that gave them, as text such as ‹gamma=›2 for messages, by key."""
    notes: list[str]
    """Notes for a person on the walkers that were read: a line each is added."""
    asks: bool
    """True if a person can answer questions."""

    def design(self, source: Any) -> "Design":
        """Return the walker of a source, with the request's values for its keys. Raises InputError.

        `source`: a Design, a template's name, or a path of a TOML file, drawing or mesh. Other text becomes a body of
        letters after the user has confirmed it.
        """
        from walkergen.core.files import assignments
        from walkergen.core.walker.design import Design
        from walkergen.files import templates

        known = not isinstance(source, str) or templates.is_path(source)
        if not known and source not in templates.all_names("walkers"):
            _confirm_text(source, self.asks)
            values = {key: self.values[key] for key in self.keys_of("design")}
            design = assignments.replace_values(Design.from_text(source), values, COMMAND_LINE_SOURCE)
        else:
            design = self._load_input(source, "walkers", Design, "design")
        if design.weighed.has_masses:
            from walkergen.core.walker import weighed_masses

            weighed_masses.check_stated_masses(design)
        self.notes.extend(note for note in design.notes if note not in self.notes)
        return design

    def scene(self, source: Any, otherwise: Mapping[str, Any] | None = None) -> "Scene":
        """Return the scene of a source, with the request's values for its keys. Raises InputError.

        `source`: a Scene, a template's name or a file's path. `otherwise`: values by key, used for keys that the
        request does not set.
        """
        from walkergen.core.scene import Scene

        defaults = {key: value for key, value in (otherwise or {}).items() if not _setting_key(self.values, key)}
        return self._replace(values={**self.values, **defaults})._load_input(source, "scenes", Scene, "scene")

    def printer(self, source: Any) -> "Printer":
        """Return the printer of a source (Printer, template's name or path), with the request's values for its keys."""
        from walkergen.core.printing.printers import Printer

        return self._load_input(source, "printers", Printer, "printer")

    def printers(self, sources: Any) -> "list[Printer]":
        """Return printers of a comma-separated list of sources, or of one source. Raises InputError for equal names."""
        listed = [name.strip() for name in sources.split(",")] if isinstance(sources, str) else [sources]
        printers = [self.printer(source) for source in listed]
        names = [printer.name for printer in printers]
        for name in names:
            if names.count(name) > 1:
                raise InputError(f"‹printer=›{str(sources)[:60]!r}: two are called {name}. Name each once.", "printer")
        return printers

    def _load_input(self, source: Any, folder: str, model: "type[Model]", thing: str) -> "Model":
        """Return a design, scene or printer (`thing`) with the request's values for its keys.

        `folder`: kind of its templates, such as "walkers".
        """
        from walkergen.core.files import assignments
        from walkergen.files import templates

        prefix = "" if thing == "design" else f"{thing}."
        values = {key.removeprefix(prefix): self.values[key] for key in self.keys_of(thing)}
        if isinstance(source, model):
            return assignments.replace_values(source, values, COMMAND_LINE_SOURCE, prefix)
        if not isinstance(source, (str, Path)):
            raise InputError(
                f"{thing}: {type(source).__name__} seen: must be a {model.__name__}, the name of a "
                "template or the path of a TOML file",
                thing,
            )
        return assignments.read_with_values(
            templates.resolve_path(source, folder), model, values, COMMAND_LINE_SOURCE, prefix
        )

    def keys_of(self, thing: str) -> list[str]:
        """Return the keys that the request sets of a section: "design", "scene" or "printer"."""
        return [key for key in self.values if section_of(key) == thing]

    def single_member(self, source: Any, tilt: float | None, legs: "Kind | None") -> "Design":
        """Return the source's walker with this tilt (deg) and kind of legs; None leaves them unchanged."""
        (member,) = self.members(
            self.design(source), None if tilt is None else [tilt], None if legs is None else [legs], whole=False
        )
        return member

    def members(
        self, design: "Design", tilts: Sequence[float] | None, kinds: "Sequence[Kind] | None", whole: bool
    ) -> "list[Design]":
        """Return the variants of a design with these tilts (deg) and kinds of legs, kinds outermost.

        None means the tilt or kind of the design or, if `whole`, those of its family.
        """
        self._check_conflicts(tilts, kinds, whole)
        if not whole:
            tilts = [design.tilt_deg] if tilts is None else tilts
            kinds = [design.kind] if kinds is None else kinds
        return design.members(tilts, kinds)

    def batch(
        self,
        design: "Design",
        tilts: Sequence[float] | None,
        kinds: "Sequence[Kind] | None",
        copies: int | Mapping[float, int],
        whole: bool,
    ) -> "tuple[list[Design], list[int]]":
        """Return the variants of a design, as `members` does, and the number of copies of each.

        `copies`: the same number for all, or numbers by tilt (deg), whose keys then are the tilts.
        """
        if isinstance(copies, int):
            members = self.members(design, tilts, kinds, whole)
            return members, [copies] * len(members)
        if tilts is not None:
            given = ",".join(f"{tilt:g}" for tilt in tilts)
            raise InputError(f"‹tilt=›{given}: ‹copies› has the tilts already. Remove one of them.", "copies")
        self.check_unset(TILTS + FAMILY_TILT_KEYS, "‹copies› has the tilts already. Remove one of them.")
        members = self.members(design, list(copies), kinds, whole)
        return members, [copies[member.tilt_deg] for member in members]

    def _check_conflicts(self, tilts: Sequence[object] | None, kinds: Sequence[object] | None, whole: bool) -> None:
        """Raise InputError for set keys that contradict the given tilts or kinds or, if `whole`, the family."""
        if whole:
            advice = "a family has the tilts of family.tilt_deg. Use ‹tilt=›12, or ‹set›"
            self.check_unset(TILTS, f"{advice} 'family.tilt_deg=[12]'")
            advice = "a family has the kinds of family.legs. Use ‹legs=›braced, or ‹set›"
            self.check_unset(KINDS, f"{advice} 'family.legs=[\"braced\"]'")
        for field, values, keys in (
            ("tilt", tilts, FAMILY_TILT_KEYS if whole else TILTS),
            ("legs", kinds, FAMILY_KIND_KEYS if whole else KINDS),
        ):
            if values is not None:
                self.check_unset(keys, f"‹{field}=›{','.join(map(str, values))} sets it too. Remove one of them.")

    def check_unset(self, keys: Sequence[str], why: str) -> None:
        """Raise InputError for the first of these keys that the request sets. `why`: reason in the message."""
        for key in keys:
            if own := _setting_key(self.values, key):
                raise InputError(f"{self.fields[own]}: {why}", key)


def _confirm_text(text: str, asks: bool) -> None:
    """Ask the user whether an unknown name is meant as letters for the body.

    Raises InputError if not, or if no user can answer. `asks`: True if the request comes from the command line.
    """
    import difflib
    import shlex
    import sys

    from walkergen.files import templates

    known = templates.all_names("walkers")
    close = difflib.get_close_matches(text, known, n=1)
    missing = f"{text[:80]!r}: no such template or file" + (f". Did you mean {close[0]}?" if close else "")
    if asks and sys.stdin.isatty() and sys.stderr.isatty():
        print(f"{missing}\nA walker of these letters? [y/N] ", end="", file=sys.stderr, flush=True)
        if sys.stdin.readline().strip().lower() in ("y", "yes"):
            return
    raise InputError(
        f"{missing}. ‹text=›{shlex.quote(text[:80])} makes a walker of these letters. Templates: {', '.join(known)}. "
        "Or give the path of a drawing, a mesh or a TOML file.",
        "design",
    )


def from_settings(settings: Mapping[str, Any], fields: Mapping[str, tuple[str, Any]], things: Sequence[str]) -> Inputs:
    """Merge the values that --set gives to keys with those that other fields of a request give.

    `settings`: values by key. `fields`: field name and value by key. `things`: sections whose keys the job accepts, of
    design, scene, printer. Raises InputError for other keys, for a key set twice, and for one within another.
    """
    values = {key: value for key, (_, value) in fields.items()}
    names = {key: f"‹{field}=›{value}" for key, (field, value) in fields.items()}
    for key, value in settings.items():
        name = f"‹set› {key[:60]}"
        if section_of(key) not in things:
            known = " and the ".join(things)
            message = f"‹set› {key[:60]}: this command takes no {section_of(key)}; it has keys of the {known}"
            raise InputError(message, key)
        for other, first in names.items():
            if other == key or _is_within(key, other) or _is_within(other, key):
                raise InputError(f"{name}: {first} sets it too. Remove one of them.", key)
        values[key], names[key] = value, name
    return Inputs(values, names, [], False)


def describe_allowed_values(key: str) -> str:
    """Describe the values that a key of a design, a scene or a printer may have; "" for no key."""
    from walkergen.core.files import config
    from walkergen.core.printing.printers import Printer
    from walkergen.core.scene import Scene
    from walkergen.core.walker.design import Design

    section = section_of(key)
    models: dict[str, type[config.Section]] = {"design": Design, "scene": Scene, "printer": Printer}
    path = tuple(key.removeprefix(f"{section}.").split("."))
    return config.describe_allowed_values(path, models[section]) if key else ""


def section_of(key: str) -> str:
    """Return the section of a key: design, scene or printer."""
    first, dot, _ = key.partition(".")
    return first if dot and first in ("scene", "printer") else "design"


def _is_within(key: str, table: str) -> bool:
    """Return whether a dotted key lies within a table or a list."""
    return key.startswith((f"{table}.", f"{table}["))


def _setting_key(values: Mapping[str, Any], key: str) -> str:
    """Return the key in `values` that sets `key`: itself, or a table that contains it; "" if it is not set."""
    for other, value in values.items():
        rest = key.removeprefix(f"{other}.")
        inside = isinstance(value, Mapping) and rest != key and rest in value
        if other == key or inside:
            return other
    return ""


def read_masses(path: Path | None, members: "Sequence[Design]") -> "tuple[dict[str, Weighings], list[str]]":
    """Read weighed masses from a file. Return those of the members by name, and a note on rows of other walkers."""
    if path is None:
        return {}, []
    from walkergen.core.walker import weighed_masses

    weighings, unused = weighed_masses.read_masses(path, members), weighed_masses.unused_parts(path, members)
    few = ", ".join(unused[:2]) + (" ..." if len(unused) > 2 else "")
    return weighings, [f"{path}: ignored rows of other walkers ({len(unused)}): {few}"] if unused else []


def add_caps(members: "Sequence[Design]", markers: str | None) -> "list[Design]":
    """Return the walkers with caps added to those without one; unchanged if `markers` is None."""
    from walkergen.core.files.assignments import replace_values

    if markers is None:
        return list(members)
    cap = {"cap.kind": "engraved"}
    return [replace_values(design, cap, design.name) if design.cap is None else design for design in members]


def filled_form_warnings(folder: Path, members: "Sequence[Design]") -> list[str]:
    """Return a note for each form for masses in the folder that is kept because a user has filled it in."""
    from walkergen.core.walker import names, weighed_masses

    paths = [folder / weighed_masses.form_name(members, name) for name in names.group_by_design(members)]
    return [f"{path}: already filled in, not overwritten" for path in paths if weighed_masses.is_filled_in(path)]


@contextmanager
def open_pool(in_process: bool, workers: int | None, dask: str | None = None) -> "Iterator[WorkerPool | None]":
    """Open a pool of worker processes, or connect to a dask cluster at the address `dask`.

    Yields None if `in_process` and no number of workers is given: this process then does the work. Raises InputError
    if `workers` and `dask` are both given, or the cluster does not answer.
    """
    from walkergen.points import worker_pool

    if dask is not None:
        if workers is not None:
            raise InputError(
                f"‹workers=›{workers}: cannot be combined with ‹dask›, which has its own workers. Remove one of them.",
                "workers",
            )
        with worker_pool.dask_pool(dask) as pool:
            yield pool
    elif in_process and workers is None:
        yield None
    else:
        with worker_pool.local_pool(workers) as pool:
            yield pool
