"""Run of the hard cases: on every processor, each on its own, so that none can stop the others.

Processes and not threads, because the first run compiles the simulators and the compiler works on
a single thread at a time.
"""

import difflib
from collections.abc import Iterator, Sequence
from concurrent.futures import as_completed
from concurrent.futures.process import BrokenProcessPool

from walkergen.errors import InputError
from walkergen.files.progress import Progress
from walkergen.jobs.trust.selftest import catalogue
from walkergen.jobs.trust.selftest.case import Case, Result, result_of, run_case
from walkergen.points import worker_pool

Job = tuple[Case, str]
"""Case, and the model to run it on."""


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
    return [(case, model) for case in cases for model in case.runs_on]


def _named(case: Case, only: str) -> bool:
    word = only.strip().lower()
    below = case.section == word or case.section.startswith(f"{word}.")
    return bool(word) and (below or word in case.name.lower())


def run(jobs: Sequence[Job], progress: Progress) -> tuple[list[Result], bool]:
    """Run jobs; results in their order, and whether all were run: Ctrl-C keeps those finished."""
    results: dict[int, Result] = {}
    progress("kernels", 0, len(jobs))
    workers = min(worker_pool.cores(), len(jobs))
    alone = ((index, run_case(*job)) for index, job in enumerate(jobs))
    try:
        for index, result in alone if workers == 1 else _run_in_processes(jobs, workers):
            results[index] = result
            progress(f"{result.case}, {result.model}", len(results), len(jobs))
    except KeyboardInterrupt:
        pass  # reported by the second value
    return [results[index] for index in sorted(results)], len(results) == len(jobs)


def _run_in_processes(jobs: Sequence[Job], workers: int) -> Iterator[tuple[int, Result]]:
    """Yield results as they come. The first jobs of each model go first, so that no two compile the same."""
    first = {model: index for index, (_, model) in reversed(list(enumerate(jobs)))}
    order = sorted(range(len(jobs)), key=lambda index: first[jobs[index][1]] != index)
    with worker_pool.local(workers) as pool:
        futures = {
            pool.executor.submit(_run_named, case.name, model): index
            for index, (case, model) in ((index, jobs[index]) for index in order)
        }
        for future in as_completed(futures):
            index = futures[future]
            try:
                yield index, future.result()
            except BrokenProcessPool:
                yield index, result_of(*jobs[index], (), "its process, or one beside it, died", 0.0)


def _run_named(name: str, model: str) -> Result:
    (case,) = [case for case in catalogue.CASES if case.name == name]
    return run_case(case, model)
