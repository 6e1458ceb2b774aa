"""What is asked of a sweep, from a command line or from a file: a request, checked."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, get_args

from walkergen.errors import InputError
from walkergen.exploring import axes
from walkergen.exploring.axes import Axis, Method, Sample, Space, Span
from walkergen.exploring.point import THEORY
from walkergen.exploring.request import Request
from walkergen.exploring.wanted import Wanted, parse
from walkergen.files import columns, templates
from walkergen.jobs.sweep import sweep_file
from walkergen.printing.printers import Printer
from walkergen.scene import Scene
from walkergen.walker.design import Design

PAPER, SCENE = "koumakis2016", "lane-90hz"
"""Templates of the design and the scene that a file need not name."""

ERROR = parse("5%")
"""Error of simulated speeds unless asked otherwise."""


class Ask(NamedTuple):
    """A sweep as it is asked for; None for what is left to defaults."""

    design: Design
    scene: Scene
    printer: Printer | None
    space: Space
    constants: Mapping[str, Any]
    """Values of dotted keys that all points share."""
    model: str
    error: Wanted | None
    keep: Sequence[str]

    def request(self) -> Request:
        """Checked request. Raises InputError.

        Simulated speeds meet ERROR unless another is asked for, or the runs are set.
        """
        keys = (*self.space.keys, *self.constants)
        own_runs = any(key in ("scene.run.runs", "scene.run.seconds") for key in keys)
        default = None if self.model == THEORY or own_runs else ERROR
        found = Request(
            self.design, self.scene, self.space, self.model, tuple(dict.fromkeys(self.keep)),
            default if self.error is None else self.error, self.printer,
        )  # fmt: skip
        found.check()
        return found.fixed(self.constants)

    def title(self) -> str:
        """Title of the pictures: the walker, where it runs, and by what."""
        model = "theory" if self.model == THEORY else f"model {self.model}"
        return f"{self.design.name}, {self.scene.name}, {model}"

    def name(self) -> str:
        """Name of the folder, after the design and the keys that vary."""
        keys = "-".join(key.rpartition(".")[2] for key in self.space.keys) or "point"
        return f"{self.design.name}-{keys}"[:100]


def of_file(path: Path) -> Ask:
    """Sweep that a file asks for. Raises InputError."""
    found = sweep_file.read(path)
    near = found.folder
    printer = None
    if found.printer is not None:
        printer = templates.load(found.printer, "printers", Printer, near)
    return Ask(
        templates.load(found.design or PAPER, "walkers", Design, near),
        templates.load(found.scene or SCENE, "scenes", Scene, near),
        printer, found.space, found.constants, found.model or THEORY, found.error,
        found.keep or ("speed",),
    )  # fmt: skip


def space_of(texts: Sequence[str], sample: str | None, seed: int) -> tuple[Space, dict[str, Any]]:
    """Space of KEY=VALUES as on a command line, and the keys of a single value. InputError."""
    given = [axes.parse(text) for text in texts]
    axes.check(given)
    spans = tuple(one for one in given if isinstance(one, Span))
    lists = [one for one in given if isinstance(one, Axis)]
    fixed = {axis.key: axis.values[0] for axis in lists if len(axis.values) == 1}
    varied = tuple(axis for axis in lists if len(axis.values) > 1)
    if sample is None:
        for span in spans:
            raise InputError(
                f"--set {span.key}={span.low:g}:{span.high:g}: write FIRST:LAST:STEP, or give "
                "--sample sobol:256 to sample between the two"
            )
        return Space(varied), fixed
    method, _, count = sample.partition(":")
    samples = columns.whole(count, axes.MOST_VALUES)
    if method not in get_args(Method) or samples is None:
        raise InputError(
            f"--sample {sample[:30]!r}: write sobol:N or latin:N, N a whole number in "
            f"1..{axes.MOST_VALUES}"
        )
    if not spans:
        raise InputError(f"--sample {sample}: no key to sample: --set KEY=LOW:HIGH")
    known: Method = "sobol" if method == "sobol" else "latin"
    return Space(varied, Sample(spans, samples, known, seed)), fixed
