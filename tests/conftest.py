"""Assertions of helper modules say what they saw, as those of tests do."""

import pytest

pytest.register_assert_rewrite("soundness", "threemf")


@pytest.fixture(scope="session", autouse=True)
def _short_simulations():
    """Simulations in place of the surrogate are a tenth as long: what they give is tested in test_short.py."""
    from walkergen.points import short

    kept = short.LONGEST_S, short.PRINT_S, short.PRINTS, short.MOST_RUNS
    short.LONGEST_S, short.PRINT_S, short.PRINTS, short.MOST_RUNS = 0.3, 0.2, 16, 8
    yield
    short.LONGEST_S, short.PRINT_S, short.PRINTS, short.MOST_RUNS = kept
