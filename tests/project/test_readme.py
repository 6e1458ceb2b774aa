"""Every command and every line of Python that the README shows is run; those of further pages at night."""

import os
import re
import shlex
import shutil
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [
    ROOT / name
    for name in (
        "README.md",
        *(f"docs/{name}.md" for name in ("app", "tutorial", "making", "running", "trusting", "python")),
    )
]
"""Pages whose commands and Python are run, in this order in one folder."""
README, TUTORIAL = (page.read_text(encoding="utf-8") for page in (PAGES[0], PAGES[2]))


def blocks(kind, pages=PAGES):
    """Text of the blocks of one language on pages, with the name of the page."""
    for page in pages:
        for text in re.findall(rf"```{kind}\n(.*?)```", page.read_text("utf-8"), flags=re.DOTALL):
            yield page.name, text


def commands(pages=PAGES):
    lines = [line for _, text in blocks("sh", pages) for line in text.splitlines()]
    return [line.split("#")[0].strip() for line in lines]


def test_the_first_page_is_short_and_shows_every_kind_of_result():
    assert len(README.splitlines()) <= 120
    assert len(README.split()) <= 600
    for made in ("export", "predict", "plate", "movie"):
        assert f"walkergen {made} " in README


def test_the_setup_is_two_commands_and_the_gate_runs_them():
    setup = [line for line in commands() if ".venv/bin" in line]
    assert len(setup) == 2
    gate = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert setup[0].startswith("python3 -m venv")
    assert "grep -m1 '^python3 -m venv' README.md" in gate
    assert setup[1].startswith(".venv/bin/pip install")
    assert r"grep -m1 '^\.venv/bin/pip install' README.md" in gate


@pytest.mark.parametrize(
    ("pages", "least"),
    [
        pytest.param(PAGES[:1], 5, marks=pytest.mark.slow, id="README"),
        pytest.param(PAGES, 26, marks=pytest.mark.nightly, id="all pages"),
    ],
)
def test_the_tour_runs_as_shown(tmp_path, pages, least):
    for name, text in re.findall(r'```csv title="([^"]+)"\n(.*?)```', TUTORIAL, flags=re.DOTALL):
        (tmp_path / name).write_text(text, encoding="utf-8")
    shutil.copytree(ROOT / "examples", tmp_path / "examples")  # commands run in the checkout
    tour = [line for line in commands(pages) if line.startswith("walkergen")]
    tour = [line for line in tour if line != "walkergen app"]  # it ends when somebody ends it: the next test
    assert len(tour) >= least
    tour.insert(0, "walkergen family koumakis2016")  # the first command of the set-up
    for line in tour:
        words = [sys.executable, "-m", *shlex.split(line)]
        result = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert result.returncode == 0, (line, result.stderr, result.stdout[-2000:])
        assert result.stdout
    if pages is PAGES:
        assert len(list((tmp_path / "out" / "mine" / "stl").iterdir())) == 34


def test_the_page_is_served_as_shown(tmp_path):
    words = [sys.executable, "-m", "walkergen", "app", "--no-browser", "--port", "0"]
    with subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE, text=True) as server:
        address = server.stdout.readline().split()[-1]
        with urllib.request.urlopen(address) as answer:
            assert b"<title>walkergen</title>" in answer.read()
        server.terminate()


@pytest.mark.slow
@pytest.mark.parametrize(("page", "code"), list(blocks("python")))
def test_the_python_runs_as_shown(page, code, tmp_path):
    words = [sys.executable, "-c", code]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    result = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert "mm/s" in result.stdout
    if page == "README.md":
        assert re.match(r"\d+ mm/s, with 95 % \d+ to \d+ mm/s", result.stdout)
        assert (tmp_path / "walker.stl").stat().st_size > 500


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_pictures_shown_exist(page):
    for picture in re.findall(r"!\[.*?\]\((.*?)\)", page.read_text(encoding="utf-8")):
        start = {".png": b"\x89PNG", ".gif": b"GIF89a"}[Path(picture).suffix]
        assert (page.parent / picture).read_bytes().startswith(start)
