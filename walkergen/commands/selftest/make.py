"""Run of the hard cases: on every processor, each on its own, so that none can stop the others.

Processes replace threads because the first run compiles the simulators and the compiler works on
a single thread at a time.
"""

import difflib
from collections.abc import Iterator, Sequence
from concurrent.futures import as_completed
from concurrent.futures.process import BrokenProcessPool

from walkergen.commands.selftest import catalogue
from walkergen.commands.selftest.case import Case, Result, make_result, run_case
from walkergen.core import measure
from walkergen.core.errors import InputError
from walkergen.core.files.progress import Progress
from walkergen.points import worker_pool


def select_cases(only: str | None) -> list[Case]:
    """Select the cases whose section is `only` or lies below it, or whose name contains it.

    All cases for None. Raises InputError when there is none.
    """
    cases = [case for case in catalogue.CASES if only is None or _is_selected(case, only)]
    if not cases:
        sections = list(dict.fromkeys(case.section for case in catalogue.CASES))
        names = [case.name for case in catalogue.CASES]
        near = difflib.get_close_matches(str(only)[:60], names, n=2, cutoff=0.4)
        hint = f"Did you mean {' or '.join(near)}?" if near else f"Sections: {', '.join(sections)}"
        raise InputError(f"‹only=›{str(only)[:30]!r}: no test case has this section or name. {hint[:120]}")
    return cases


def _is_selected(case: Case, only: str) -> bool:
    """Return whether a case has the section or name `only`."""
    word = only.strip().lower()
    in_section = case.section == word or case.section.startswith(f"{word}.")
    return bool(word) and (in_section or word in case.name.lower())


def run_cases(cases: Sequence[Case], progress: Progress) -> tuple[list[Result], bool]:
    """Run cases. Return results in their order, and whether all were run: Ctrl-C keeps finished ones."""
    results: dict[int, Result] = {}
    progress("kernels", 0, len(cases))
    workers = min(measure.core_count(), len(cases))
    in_turn = ((index, run_case(case)) for index, case in enumerate(cases))
    try:
        for index, result in in_turn if workers == 1 else _run_in_processes(cases, workers):
            results[index] = result
            progress(result.case, len(results), len(cases))
    except KeyboardInterrupt:
        pass  # reported by the second value
    return [results[index] for index in sorted(results)], len(results) == len(cases)


def _run_in_processes(cases: Sequence[Case], workers: int) -> Iterator[tuple[int, Result]]:
    """Yield results as they arrive. The first cases of each kind start first, so that no two compile the same."""
    first = {case.on: index for index, case in reversed(list(enumerate(cases)))}
    order = sorted(range(len(cases)), key=lambda index: first[cases[index].on] != index)
    with worker_pool.local_pool(workers) as pool:
        futures = {pool.executor.submit(_run_named, cases[index].name): index for index in order}
        for future in as_completed(futures):
            index = futures[future]
            try:
                yield index, future.result()
            except BrokenProcessPool:
                yield index, make_result(cases[index], (), "its process, or another one, died", 0.0)


def _run_named(name: str) -> Result:
    """Run the case of a name: names can be sent to other processes."""
    (case,) = [case for case in catalogue.CASES if case.name == name]
    return run_case(case)
