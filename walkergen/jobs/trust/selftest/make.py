"""Run of the hard cases: on every processor, each on its own, so that none can stop the others.

Processes and not threads, because the first run compiles the simulators and the compiler works on
a single thread at a time.
"""

import difflib
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, as_completed
from concurrent.futures.process import BrokenProcessPool
from typing import NamedTuple

from walkergen.errors import InputError
from walkergen.files.progress import Progress
from walkergen.jobs.trust.selftest import catalogue
from walkergen.jobs.trust.selftest.case import METHODS, Case, Check
from walkergen.points import worker_pool


class Job(NamedTuple):
    """Case to run on one model."""

    case: Case
    model: str


class Result(NamedTuple):
    """Result of a job."""

    section: str
    case: str
    source: str
    model: str
    method: str
    checks: tuple[Check, ...]
    """Checks that were made before an error, or all of them."""
    error: str
    """Error that the case raised, in one line; empty when it ran to its end."""
    seconds: float

    @property
    def holds(self) -> bool:
        """True when the case ran to its end and all its checks hold."""
        return not self.error and all(check.holds for check in self.checks)


def choose(only: str | None) -> list[Job]:
    """Select the jobs whose section is `only` or lies below it, or whose case's name contains it.

    All jobs for None. Raises InputError when there is none.
    """
    cases = [case for case in catalogue.CASES if only is None or _named(case, only)]
    if not cases:
        sections = list(dict.fromkeys(case.section for case in catalogue.CASES))
        names = [case.name for case in catalogue.CASES]
        near = difflib.get_close_matches(str(only)[:60], names, n=2, cutoff=0.4)
        hint = f"did you mean {' or '.join(near)}?" if near else f"sections: {', '.join(sections)}"
        raise InputError(f"--only {str(only)[:30]!r}: no hard case has this section or name; {hint[:120]}")
    return [Job(case, model) for case in cases for model in case.runs_on]


def _named(case: Case, only: str) -> bool:
    word = only.strip().lower()
    below = case.section == word or case.section.startswith(f"{word}.")
    return bool(word) and (below or word in case.name.lower())


def run_job(job: Job) -> Result:
    """Run a case; an error that it raises is reported as its failure."""
    started, checks, error = time.perf_counter(), list[Check](), ""
    try:
        checks.extend(job.case.check(job.model))
    except Exception as raised:  # any error at all: the table must name it
        error = f"{type(raised).__name__}: {' '.join(str(raised).split())}"
    if not (checks or error):
        error = "it checked nothing"
    return _result(job, tuple(checks), error, time.perf_counter() - started)


def _result(job: Job, checks: tuple[Check, ...], error: str, seconds: float) -> Result:
    case, method = job.case, METHODS[job.model]
    return Result(case.section, case.name, case.source, job.model, method, checks, error, seconds)


def run(jobs: Sequence[Job], progress: Progress) -> tuple[list[Result], bool]:
    """Run jobs; results in their order, and whether all were run: Ctrl-C keeps those finished."""
    results: dict[int, Result] = {}
    progress("kernels", 0, len(jobs))
    workers = min(worker_pool.cores(), len(jobs))
    try:
        for index, result in _in_process(jobs) if workers == 1 else _in_processes(jobs, workers):
            results[index] = result
            progress(f"{result.case}, {result.model}", len(results), len(jobs))
    except KeyboardInterrupt:
        pass  # reported by the second value
    return [results[index] for index in sorted(results)], len(results) == len(jobs)


def _in_process(jobs: Sequence[Job]) -> Iterator[tuple[int, Result]]:
    for index, job in enumerate(jobs):
        yield index, run_job(job)


def _in_processes(jobs: Sequence[Job], workers: int) -> Iterator[tuple[int, Result]]:
    with worker_pool.local(workers) as pool:
        futures: dict[Future[Result], int] = {}
        for index in _compilers_first(jobs):
            job = jobs[index]
            futures[pool.executor.submit(_run_named, job.case.name, job.model)] = index
        for future in as_completed(futures):
            index = futures[future]
            try:
                yield index, future.result()
            except BrokenProcessPool:
                yield index, _result(jobs[index], (), "its process, or one beside it, died", 0.0)


def _compilers_first(jobs: Sequence[Job]) -> list[int]:
    """Indices of jobs, the first of each model in front: no two compile the same."""
    compiled = set[str]()
    first, rest = list[int](), list[int]()
    for index, job in enumerate(jobs):
        (rest if job.model in compiled else first).append(index)
        compiled.add(job.model)
    return first + rest


def _run_named(name: str, model: str) -> Result:
    (case,) = [case for case in catalogue.CASES if case.name == name]
    return run_job(Job(case, model))
