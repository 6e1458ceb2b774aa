"""Assertions of helper modules say what they saw, as those of tests do."""

import pytest

pytest.register_assert_rewrite("soundness", "threemf")
