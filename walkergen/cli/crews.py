"""Crews that a command line asks for: processes here, or a cluster."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.errors import InputError

if TYPE_CHECKING:
    from walkergen.points.crew import Crew

Workers = Annotated[
    int | None,
    typer.Option("--workers", metavar="N", help="Number of processes; all cores by default."),
]


@contextmanager
def crew_of(few: bool, workers: int | None, dask: str | None = None) -> "Iterator[Crew | None]":
    """Crew for points; none, unless asked for, where they are so `few` that this process is faster.

    Raises InputError for a number of processes of a cluster, and for one that does not answer.
    """
    from walkergen.points import crew

    if dask is not None:
        if workers is not None:
            raise InputError(f"--workers {workers}: not with --dask, which has its own")
        with crew.dask(dask) as found:
            yield found
    elif few and workers is None:
        yield None
    else:
        with crew.local(workers) as found:
            yield found
