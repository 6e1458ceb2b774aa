"""Walkers in a notebook: a frame of its own that draws them on their feet, trusting no text."""

import base64
import io
import json
import os
import re
import zlib
from html import unescape
from html.parser import HTMLParser

import matplotlib.image
import numpy as np
import pytest
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select, WebDriverWait
from test_page_browser import BROWSER, DRIVER, WANTED, browser_at, requested

import walkergen as wg
from walkergen.core.errors import InputError
from walkergen.core.shapes import stl
from walkergen.core.walker import solids
from walkergen.files import viewer

HOSTILE = "</script></iframe>\"'><script>alert(1)</script><img src=//x.org/x onerror=alert(1)>"

PAPER = wg.load("koumakis2016", "walker")
BRISTLE = wg.load("bristle", "walker")


class Outer(HTMLParser):
    """Elements of a notebook's output, and the text that stands in none of its frames."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.frames, self.words = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        if tag == "iframe":
            self.frames.append(dict(attributes))

    def handle_data(self, data):
        self.words.append(data)


def held(document, name):
    """Content of an element of the frame's page."""
    return re.search(rf'id="{name}">(.*?)</script>', document, re.DOTALL)[1]


@pytest.mark.parametrize("design", [PAPER, BRISTLE], ids=["on its side", "legs up"])
def test_a_design_is_shown_as_it_stands_with_a_table_below_it(design):
    found = Outer(design._repr_html_())
    (frame,) = found.frames
    assert frame["sandbox"] == "allow-scripts"
    (part,) = json.loads(held(frame["srcdoc"], "parts"))
    data = zlib.decompress(base64.b64decode(held(frame["srcdoc"], "meshes")))
    corners = np.frombuffer(data, "<f4").reshape(-1, 3)
    assert len(corners) == 3 * part["triangles"]
    mesh = solids.build(design).walker
    np.testing.assert_allclose(corners, mesh.vertices[mesh.triangles.ravel()], atol=1e-5)
    lowest = corners[corners[:, 1] < corners[:, 1].min() + 0.01]
    assert np.ptp(lowest[:, 0]) > 5.0  # feet, apart along the run
    assert f"{float(solids.mass_of(design).total):.4g}" in found.words
    assert found.tags.index("iframe") < found.tags.index("table")


def test_the_size_is_told_and_nothing_is_fetched():
    text = PAPER._repr_html_()
    (told,) = re.findall(r"3D view: ([0-9.]+) MB of this notebook", text)
    assert float(told) == pytest.approx(len(text) / 1e6, abs=0.01)
    assert len(text) < 250_000
    assert text == PAPER._repr_html_()
    document = unescape(Outer(text).frames[0]["srcdoc"])
    policy = re.search(r'Content-Security-Policy" content="(.*?)"', document)[1]
    assert policy.startswith("default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'sha256-")
    assert "unsafe-eval" not in policy
    assert not re.search(r'<[^>]+\b(src|href)="(?!data:)', document)
    packed = zlib.decompress(base64.b64decode(held(document, "viewer"))).decode()
    assert packed == viewer.viewer_script()


def test_text_of_files_is_only_text():
    design = PAPER.model_copy(update={"description": HOSTILE})
    found = Outer(design._repr_html_())
    assert "script" not in found.tags
    assert "img" not in found.tags
    assert HOSTILE in "".join(found.words)
    mesh = solids.build(PAPER).walker
    one = viewer.Part(HOSTILE, "flexible", mesh.vertices, mesh.triangles)
    found = Outer(viewer.render_frame([one, one], HOSTILE))
    assert found.tags == ["iframe", "p", "small"]
    assert found.frames[0]["title"] == HOSTILE
    inner = Outer(found.frames[0]["srcdoc"])
    assert "img" not in inner.tags
    assert inner.tags.count("script") == 4
    assert [part["name"] for part in json.loads(held(found.frames[0]["srcdoc"], "parts"))] == ([HOSTILE] * 2)


def test_what_is_too_fine_is_left_out_by_name_and_what_cannot_stand_says_why(monkeypatch):
    mesh = solids.build(PAPER).walker
    parts = [viewer.Part(name, "flexible", mesh.vertices, mesh.triangles) for name in "abc"]
    monkeypatch.setattr(viewer, "MAX_TRIANGLES", 2 * len(mesh.triangles))
    text = viewer.render_frame(parts, "t")
    assert "1 of 3 parts are not in the 3D view" in text
    assert text.endswith("at most: c</p>")
    monkeypatch.setattr(viewer, "MAX_TRIANGLES", 1)
    assert "iframe" not in viewer.render_frame(parts, "t")
    monkeypatch.setattr(solids, "build", lambda design: (_ for _ in ()).throw(InputError("<why>")))
    assert PAPER._repr_html_().endswith("<th>cannot be shown</th><td>&lt;why&gt;</td></tr></tbody></table>")


@pytest.fixture(scope="module")
def bristles(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bristle")
    return wg.family(BRISTLE, folder, tilt=[0, 20], model="theory", pictures=False, page=True)


def test_the_stl_of_a_family_is_what_its_name_says(bristles):
    data = (bristles.folder / "stl" / f"{bristles.members[0].name}.stl").read_bytes()
    corners = stl.unpack(data, "x")[0].reshape(-1, 3)
    top = corners[corners[:, 2] > corners[:, 2].max() - 0.01]
    assert np.ptp(top[:, 0]) > 15.0  # feet, in the air


@pytest.fixture(scope="module")
def browser(bristles, tmp_path_factory):
    folder = tmp_path_factory.mktemp("bare")
    (folder / "bare.html").write_text(
        f"<!DOCTYPE html><meta charset=utf-8><body>{bristles._repr_html_()}", encoding="utf-8"
    )
    browser = browser_at(folder / "bare.html", folder / "profile")
    browser.implicitly_wait(10)
    yield browser
    browser.quit()


def until_drawn(browser):
    """Wait until the frame tells which part it shows."""
    WebDriverWait(browser, 10, 0.05).until(lambda found: "Lines are" in found.find_element(By.ID, "told").text)


def part(browser):
    """Pixels of the canvas that are the part's."""
    png = browser.find_element(By.ID, "canvas").screenshot_as_png
    return np.ptp(matplotlib.image.imread(io.BytesIO(png))[:, :, :3], axis=2) > 0.2


def is_on_its_feet(browser):
    browser.find_element(By.CSS_SELECTOR, "[data-view=front]").click()
    seen = part(browser)
    widths = seen[seen.any(axis=1)].sum(axis=1)  # from the top down
    body, legs = widths[len(widths) // 10], widths[-len(widths) // 5]
    return 0.05 * body < legs < 0.5 * body  # six rows of thin legs below a body


@pytest.mark.slow
@pytest.mark.programs
@pytest.mark.skipif(not (BROWSER and DRIVER) and "CI" not in os.environ, reason=WANTED)
class TestInABrowser:
    def test_a_bare_page_draws_the_family_on_its_feet(self, browser):
        browser.switch_to.frame(browser.find_element(By.TAG_NAME, "iframe"))
        until_drawn(browser)
        assert 0.03 < part(browser).mean() < 0.6
        assert is_on_its_feet(browser)
        upright = part(browser)
        Select(browser.find_element(By.ID, "part")).select_by_index(1)
        assert np.mean(part(browser) != upright) > 0.005
        assert "t20.0" in browser.find_element(By.ID, "told").text
        browser.find_element(By.ID, "slide").send_keys(Keys.ARROW_LEFT)
        assert "t00.0" in browser.find_element(By.ID, "told").text
        assert browser.find_element(By.ID, "part").get_attribute("value") == "0"
        browser.switch_to.default_content()
        assert "3D view: 0.2" in browser.find_element(By.TAG_NAME, "small").text

    def test_the_page_shows_it_on_its_feet_too_and_nobody_complains(self, browser, bristles):
        browser.get((bristles.folder / "report.html").as_uri())
        until_drawn(browser)
        assert is_on_its_feet(browser)
        assert [one for one in browser.get_log("browser") if one["level"] != "INFO"] == []
        own = ("file:", "data:", "blob:", "about:srcdoc")
        assert [url for url in requested(browser) if not url.startswith(own)] == []
