"""Fixtures of many tests; assertions of helper modules say what they saw, as those of tests do."""

import pytest
from typer.testing import CliRunner

pytest.register_assert_rewrite("command_checks", "mesh_checks", "threemf")


@pytest.fixture(scope="session", autouse=True)
def _short_simulations():
    """Simulations in place of the surrogate are a tenth as long: what they give is tested in test_short.py."""
    from walkergen.points import short_simulation

    with pytest.MonkeyPatch.context() as patch:
        for name, value in {"MAX_RUN_S": 0.3, "PRINT_S": 0.2, "PRINT_COUNT": 16, "MAX_RUNS": 8}.items():
            patch.setattr(short_simulation, name, value)
        yield


@pytest.fixture
def run(request, tmp_path, monkeypatch):
    """Run the command line with words, in an empty folder and cache; first those of the module's COMMAND."""
    from walkergen.cli import command_line

    monkeypatch.chdir(tmp_path)
    command = getattr(request.module, "COMMAND", ())
    return lambda *words: CliRunner().invoke(command_line, [*command, *map(str, words)])


@pytest.fixture
def home(tmp_path, monkeypatch):
    """Empty working folder, with a cache of its own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path


@pytest.fixture
def undrawn(monkeypatch):
    """Pictures take longer than all the rest of a short film's tracking."""
    monkeypatch.setattr("walkergen.files.figures.png", lambda figure: b"")
