"""No module needs itself: imports run in no circle, also those of functions and those for types."""

import grimp


def test_imports_run_in_no_circle():
    graph = grimp.build_graph("walkergen", "evidence", exclude_type_checking_imports=False, cache_dir=None)
    needs = {module: graph.find_upstream_modules(module) | {module} for module in graph.modules}
    circles = {frozenset(other for other in needed if one in needs[other]) for one, needed in needs.items()}
    assert [sorted(circle) for circle in circles if len(circle) > 1] == []
