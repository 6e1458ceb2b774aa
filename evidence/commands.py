"""Commands of `python -m evidence`, each with its request."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from pydantic import BeforeValidator

from walkergen import field_values, request
from walkergen.cli import command_builder
from walkergen.cli.command_builder import HELP_OPTIONS, Command
from walkergen.core.files.progress import Expected, Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from evidence.crowds_published.cases import Size
    from walkergen.files.report import Report

Quick = Annotated[bool, Flag("Simulate less: wider error bars.")]


def _parse_drives(value: object) -> list[float]:
    """Return the drives (g) of a text with commas or of a list."""
    numbers = [field_values.parse_number(word) for word in field_values.split_values(value)]
    if not all(0.01 <= number <= 50.0 for number in numbers):
        raise ValueError("each must lie in 0.01..50")
    return numbers


class ValidateRequest(request.Request):
    """Compare every prediction with outside results: number, error, source, verdict."""

    only: Annotated[
        str | None, Flag("Comma-separated groups: paper, closed, bouncing, rivals, programs.", "GROUPS")
    ] = None
    quick: Quick = False
    out: request.Out = None

    def run(self, progress: Progress) -> "Report":
        """Measure the claims."""
        from evidence.validate import make
        from evidence.validate.claim import Effort

        groups = make.parse_groups(self.only)
        choice = (f" --only {','.join(groups)}" if self.only else "") + (" --quick" if self.quick else "")
        folder = self.out or Path("out") / "validation"
        return make.validate(groups, Effort(self.quick), f"python -m evidence validate{choice}", folder, progress)


class CrowdChecksRequest(request.Request):
    """Compare walkers in a plane with walkers in space."""

    quick: Quick = False
    out: request.Out = None

    def run(self, progress: Progress) -> "Report":
        """Compare. Raises InputError without LAMMPS."""
        from evidence.crowd_checks import make
        from evidence.crowd_checks.setting import FULL, QUICK

        command = "python -m evidence crowd-checks" + (" --quick" if self.quick else "")
        setting = QUICK if self.quick else FULL
        return make.compare_crowds(setting, command, self.out or Path("out") / "crowd-checks", progress)


class CrowdsPublishedRequest(request.Request):
    """Compare our crowds with published ones."""

    quick: Quick = False
    seconds: request.Seconds = None
    runs: request.Runs = None
    seed: request.Seed = None
    out: request.Out = None

    def run(self, progress: Progress) -> "Report":
        """Compare."""
        from evidence.crowds_published import make

        size = self._size()
        self._expect(lambda: Expected(make.expected_s(size)))
        return make.compare_crowds(size, self.out or Path("out") / "crowds-published", progress)

    def _size(self) -> "Size":
        """Return the size of the comparison, with defaults for what was not given. Raises InputError."""
        from evidence.crowds_published import make
        from evidence.crowds_published.cases import FULL, QUICK

        size = QUICK if self.quick else FULL
        size = size._replace(
            runs=size.runs if self.runs is None else self.runs,
            seconds=size.seconds if self.seconds is None else self.seconds,
            seed=size.seed if self.seed is None else self.seed,
        )
        make.check_size(size)
        return size


class WalkersPublishedRequest(request.Request):
    """Predict published walkers over all that their authors leave open."""

    only: Annotated[str | None, Flag("Comma-separated sets: koumakis2016, deseigne2010, son2025.", "SETS")] = None
    out: request.Out = None

    def run(self, progress: Progress) -> "Report":
        """Predict them; what was simulated before is kept."""
        from evidence.walkers_published import make

        sets = make.parse_sets(self.only)
        self._expect(lambda: Expected(make.expected_s(sets)))
        return make.compare_walkers(sets, self.out or Path("out") / "walkers-published", progress)


class ReproduceRequest(request.Request):
    """Compare the paper's figures and mechanisms with ours."""

    tilt: request.Tilts = None
    gamma: Annotated[
        list[float] | None,
        BeforeValidator(_parse_drives),
        Flag("Drives of figure 5: 1.2,1.8,2.4.", "G", takes="str | Iterable[float] | None"),
    ] = None
    seconds: request.Seconds = None
    runs: request.Runs = None
    seed: request.Seed = None
    out: request.Out = None

    def run(self, progress: Progress) -> "Report":
        """Compare."""
        from evidence.reproduce import make

        run = self.model_dump(include={"seconds", "runs", "seed"}, exclude_none=True)
        return make.reproduce(
            make.make_job(self.tilt, self.gamma, run), self.out or Path("out") / "reproduce", progress
        )


class ExampleDataRequest(request.Request):
    """Write an archive of example data: a film, a recording of the plate, a card, and what is found in them."""

    quick: Quick = False
    out: request.Out = None

    def run(self, progress: Progress) -> "Report":
        """Write it."""
        from evidence.example_data import make

        return make.make_archive(
            make.QUICK if self.quick else make.FULL, self.out or Path("out") / "example-data", progress
        )


REQUESTS: dict[str, type[request.Request]] = {
    "validate": ValidateRequest,
    "crowd-checks": CrowdChecksRequest,
    "crowds-published": CrowdsPublishedRequest,
    "walkers-published": WalkersPublishedRequest,
    "reproduce": ReproduceRequest,
    "example-data": ExampleDataRequest,
}

commands = typer.Typer(
    no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False, context_settings=HELP_OPTIONS
)
for _name, _request in REQUESTS.items():
    commands.command(_name, cls=Command)(command_builder.make_function(_name, _request))
