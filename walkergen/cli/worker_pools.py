"""Worker pools that a command line asks for: processes here, or a cluster."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from walkergen.errors import InputError

if TYPE_CHECKING:
    from walkergen.points.worker_pool import WorkerPool

Workers = Annotated[
    int | None, typer.Option("--workers", metavar="N", help="Number of processes; all cores by default.")
]


@contextmanager
def pool_of(few: bool, workers: int | None, dask: str | None = None) -> "Iterator[WorkerPool | None]":
    """Workers for points; none, unless asked for, where so `few` are faster in this process.

    Raises InputError for a number of processes of a cluster, and for one that does not answer.
    """
    from walkergen.points import worker_pool

    if dask is not None:
        if workers is not None:
            raise InputError(f"--workers {workers}: not with --dask, which has its own")
        with worker_pool.dask(dask) as found:
            yield found
    elif few and workers is None:
        yield None
    else:
        with worker_pool.local(workers) as found:
            yield found
