"""The site builds without a warning, and holds what the README shows and the docstrings say."""

import ast
import base64
import os
import re
import subprocess
import sys
from pathlib import Path
from urllib.parse import urlparse

import pytest
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait
from test_page_browser import BROWSER, DRIVER, WANTED, browser_at, requested

import walkergen as wg

ROOT = Path(__file__).parents[2]

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Folder of the site, built once: its notebooks are run."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    built = subprocess.run(
        command, cwd=ROOT, env=os.environ | {"NO_MKDOCS_2_WARNING": "1"}, capture_output=True, text=True, check=False
    )
    assert built.returncode == 0, built.stderr
    assert "WARNING" not in built.stderr
    return folder


def test_the_reference_is_of_docstrings_and_begins_with_what_people_call(site):
    assert "walkergen.core.theory.prediction.predict" in (site / "api" / "core.html").read_text()
    page = (site / "api" / "python.html").read_text()
    headings = re.findall(r"^ *wg\.(\w+)$", page, flags=re.MULTILINE)
    assert headings[:4] == ["load", "predict", "simulate", "family"]
    assert set(headings) == {name for name in wg.__all__ if name.islower()} - {"__version__"} | {"WalkergenError"}
    assert "Measured time of each simulated run" in page  # from a field


def test_the_reference_has_every_class_that_calls_take_and_return(site):
    entries = {
        name for page in (site / "api").glob("*.html") for name in re.findall(r'id="([\w.]+)"', page.read_text())
    }
    named = {
        f"{part.module}.{name.name}"
        for part in ast.parse((ROOT / "walkergen" / "__init__.pyi").read_text()).body
        if isinstance(part, ast.ImportFrom) and part.module.startswith("walkergen")
        for name in part.names
    }
    assert named - entries <= {
        # Under their names as wg.load and so on
        *("walkergen.api.loading.load", "walkergen.api.loading.templates", "walkergen.core.errors.WalkergenError"),
        *("walkergen.core.files.progress.Progress", "walkergen.core.walker.limbs.Kind"),  # names of types
    }


def test_a_page_has_every_picture_with_its_command_below(site):
    pictures = {path.name for path in (ROOT / "docs").glob("*.[pg][ni][gf]")}
    pictures -= {"cheat-sheet.png"}  # of the PDF, whose page has the text
    assert pictures
    parts = (site / "pictures.html").read_text().split("<img ")[1:]
    shown = {}
    for part in parts:
        shown[re.search(r'src="(.*?)"', part)[1]] = re.sub("<.*?>", "", part)
    assert pictures <= set(shown)
    for name in pictures:
        assert (site / name).exists()
        assert re.search("walkergen |python -m evidence[ .]", shown[name].partition("</div>")[0]), name


def test_notebooks_show_the_outputs_of_this_code(site):
    folder = site / "examples"
    design, film = (folder / f"{name}.html" for name in ("design-a-walker", "film-meets-simulation"))
    assert "must be a number" in design.read_text()  # what a cell printed
    assert 'sandbox="allow-scripts" srcdoc=' in design.read_text()  # a family in 3D
    assert re.search(r"apart by -?\d\.\d standard errors", film.read_text())
    for page in (design, film):
        figures = re.findall(r'<img alt="Figure" src="(.*?)"', page.read_text())
        assert len(figures) == 2
        assert all((folder / figure).read_bytes().startswith(b"\x89PNG") for figure in figures)
        assert "Traceback" not in page.read_text()


def test_pages_load_nothing_from_elsewhere(site):
    for page in site.rglob("*.html"):
        loaded = re.findall(r'<(?:script|link|img|iframe)[^>]+(?:src|href)="(https?:[^"]+)"', page.read_text())
        assert loaded == [], page


@pytest.mark.programs
@pytest.mark.skipif(not (BROWSER and DRIVER) and "CI" not in os.environ, reason=WANTED)
def test_a_search_gives_pages_where_the_site_is_opened_as_files(site, tmp_path):
    browser = browser_at(site / "failing.html", tmp_path)
    try:
        browser.find_element(By.CSS_SELECTOR, "input.md-search__input").send_keys("restitution")
        found = WebDriverWait(browser, 60).until(
            lambda page: page.find_elements(By.CSS_SELECTOR, "a.md-search-result__link")
        )
        targets = [urlparse(one.get_attribute("href")) for one in found]
        assert len(targets) > 3
        for target in targets:
            assert target.scheme == "file"
            assert Path(target.path).exists()
        assert {urlparse(url).scheme for url in requested(browser)} <= {"file", "data", "blob"}
    finally:
        browser.quit()


PAPERS = {"A4": (210.0, 297.0), "letter": (215.9, 279.4)}
"""Widths and heights of paper, mm."""


@pytest.mark.programs
@pytest.mark.skipif(not (BROWSER and DRIVER) and "CI" not in os.environ, reason=WANTED)
def test_the_lesson_without_a_shaker_prints_on_two_sheets(site, tmp_path):
    browser = browser_at(site / "table-lesson.html", tmp_path)
    try:
        for wide, high in PAPERS.values():
            paper = {"paperWidth": wide / 25.4, "paperHeight": high / 25.4}
            printed = browser.execute_cdp_cmd("Page.printToPDF", paper)
            pages = re.findall(rb"/Type\s*/Page\b", base64.b64decode(printed["data"]))
            assert len(pages) == 2
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        # 182 mm between margins, at 96 pixels an inch: nothing is cut off at the right
        browser.set_window_size(int(182.0 / 25.4 * 96.0), 1000)
        tables = browser.find_elements(By.CSS_SELECTOR, ".md-typeset__scrollwrap")
        assert len(tables) == 4
        for table in tables:
            assert int(table.get_property("scrollWidth")) <= int(table.get_property("clientWidth"))
        assert not browser.find_element(By.CSS_SELECTOR, ".md-header").is_displayed()
    finally:
        browser.quit()
