"""Request of the command `selftest`."""

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, ClassVar

from walkergen import request
from walkergen.core.files.progress import Progress
from walkergen.request import Flag

if TYPE_CHECKING:
    from walkergen.files.report import Report


class SelftestRequest(request.Request):
    """Run the hard cases, each with an exact outcome or an invariant; exit code 1 if any fails.

    Notes
    -----
    Section 6 of docs/physics.md lists the cases.

    Examples
    --------
    >>> import walkergen as wg
    >>> wg.selftest("6.4").code
    0
    """

    by_position: ClassVar = ("only",)

    only: Annotated[
        str | None, request.AsText, Flag("Case to run, or section: 6.4.", "NAME-OR-SECTION", takes="str | None")
    ] = None
    all: Annotated[bool, Flag("Print each case with its check closest to the limit.")] = False

    def run(self, progress: Progress) -> "Report":
        """Run the cases."""
        from walkergen.commands.selftest import make, report

        jobs = make.select_cases(self.only)
        results, whole = make.run_cases(jobs, progress)
        found = report.make_report(results, whole, self.all)
        if not whole:
            return replace(found, warnings=[f"interrupted after {len(results)} of {len(jobs)}"], code=130)
        return replace(found, code=0 if all(result.holds for result in results) else 1)
