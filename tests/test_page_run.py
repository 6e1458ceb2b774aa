"""A run on the report page: what is played is what was simulated; and in a real browser."""

import base64
import io
import json
import os
import re
import time

import matplotlib.image
import numpy as np
import pytest
from report_folder import folder_of, job_of, text_of
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait
from test_page_browser import BROWSER, DRIVER, WANTED, browser_at, pixels, size, styled

from walkergen.errors import InputError
from walkergen.files import templates
from walkergen.jobs.make.family import make as family
from walkergen.jobs.make.family import play
from walkergen.scene import Scene
from walkergen.shapes import stl
from walkergen.simulation import poses
from walkergen.simulation.plan import prepare
from walkergen.walker import solids
from walkergen.walker.design import Design

PLANE = templates.load("plane-90hz", "scenes", Scene)

in_a_browser = [
    pytest.mark.slow,
    pytest.mark.programs,
    pytest.mark.skipif(not (BROWSER and DRIVER) and "CI" not in os.environ, reason=WANTED),
]


def floats(text, width):
    return np.frombuffer(base64.b64decode(text), "<f4").reshape(-1, width).astype(float)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    design = templates.load("koumakis2016", "walkers", Design).variant(tilt_deg=35.0)
    return folder_of(tmp_path_factory.mktemp("family") / "mine", (10.0, 35.0), design=design, run_in=PLANE)


def run_of(folder):
    """What the page of a folder plays."""
    return json.loads(re.search(r'id="run-data">(.*?)</script>', text_of(folder), re.DOTALL)[1])


@pytest.fixture(scope="module")
def run(folder):
    return run_of(folder)


@pytest.fixture(scope="module")
def truth():
    (design,) = templates.load("koumakis2016", "walkers", Design).members([35.0], ["flexible"])
    changed = PLANE.run.model_copy(update={"seconds": play.SECONDS})
    scene = PLANE.model_copy(update={"run": changed})
    return poses.sample(prepare(scene, design, solids.mass_of(design)), 1.0 / play.RATE)


@pytest.mark.slow
def test_the_part_stands_where_the_run_has_it(run, truth):
    rows, corners = floats(run["poses"], 7), np.array(run["corners"])
    assert len(rows) == len(truth.times) == 2001
    assert np.linalg.norm(rows[:, 3:], axis=1) == pytest.approx(1.0, abs=1e-6)
    for at in range(0, len(rows), 50):
        v, w = rows[at, 3:6], rows[at, 6]
        turned = corners + 2 * np.cross(v, np.cross(v, corners) + w * corners)
        # The mesh is rigid, legs bend by up to some hundredths of a millimetre.
        assert turned + rows[at, :3] == pytest.approx(truth.corners[at], abs=0.1)


def test_corners_are_those_of_the_part(run, folder):
    name = "walker_t35.0_flexible_s0.40.stl"
    points = stl.unpack((folder / "stl" / name).read_bytes(), name)[0].reshape(-1, 3)
    half = 0.2 / np.cos(np.radians(35.0))  # of a flat foot's width
    for corner in run["corners"]:
        assert np.linalg.norm(points - corner, axis=1).min() == pytest.approx(half, abs=0.05)


def test_lights_are_those_of_the_landings(run, truth):
    landings = floats(run["landings"], 3)
    assert len(landings) == len(truth.landings) > 100
    assert landings[:, 0] == pytest.approx(truth.landings[:, 0], abs=1e-6)
    assert (landings[:, 1] == truth.landings[:, 1]).all()
    assert landings[:, 2].max() == pytest.approx(1.0, abs=1e-6)
    strongest = np.argmax(np.hypot(truth.landings[:, 2], truth.landings[:, 3]))
    assert np.argmax(landings[:, 2]) == strongest
    masks = np.frombuffer(base64.b64decode(run["closed"]), np.uint8)
    assert (np.unpackbits(masks[:, None], axis=1)[:, :4] == truth.closed).all()


def test_a_run_is_small_and_cited_where_there_is_one(folder, tmp_path):
    with_run, plain = text_of(folder), text_of(folder_of(tmp_path, (10.0, 35.0)))
    assert len(with_run) - len(plain) < 300_000
    assert "Numba" in with_run
    assert 'id="run-data"' not in plain
    assert 'id="run"' not in plain


def test_the_page_plays_the_design_itself_or_the_first_member(run, tmp_path):
    assert run["words"].startswith("walker_t35.0_flexible_s0.40 in plane-90hz: 90 Hz, 1.8 g")
    assert run["member"] == 1
    other = run_of(folder_of(tmp_path, (20.0, 35.0), pictures=False, run_in=PLANE))
    assert (other["member"], other["words"].partition(" ")[0]) == (0, "walker_t20.0_flexible_s0.40")


def test_a_scene_in_which_the_walker_moves_in_a_plane_is_refused_before_anything_is_written(tmp_path):
    planar = Scene.model_validate({"drive": {"frequency_hz": 90.0, "gamma": 1.8}, "legs": {"model": "compliant"}})
    with pytest.raises(InputError, match="the walker moves in a plane"):
        family.make(job_of((10.0,), run_in=planar), tmp_path / "x", lambda *told: None, lambda findings: None)
    assert not (tmp_path / "x").exists()


@pytest.fixture(scope="module")
def browser(folder, tmp_path_factory):
    browser = browser_at(folder / "report.html", tmp_path_factory.mktemp("profile"))
    yield browser
    browser.quit()


def move_to(browser, seconds):
    browser.execute_script(
        "const s = document.getElementById('time'); s.value = arguments[0];s.dispatchEvent(new Event('input'));",
        seconds,
    )


def luminance(colour):
    """Relative luminance of a colour of the screen, by WCAG 2.2."""
    linear = np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


def orange(image):
    """Number of pixels in the colour of the lights."""
    red, green, blue = np.moveaxis(image, 2, 0)
    return int(((red > 0.75) & (green < 0.6) & (blue < 0.4)).sum())


def shown_ms(browser):
    """Time that the page shows, ms."""
    return float(browser.find_element(By.ID, "time-shown").text.removesuffix(" ms"))


class TestInABrowser:
    pytestmark = in_a_browser

    def test_the_slider_moves_the_part_along_its_run(self, browser):
        assert browser.find_element(By.ID, "shown").text.startswith("walker_t35.0_flexible")
        browser.find_element(By.CSS_SELECTOR, "[data-view=above]").click()
        move_to(browser, 0.0)
        start = pixels(browser)
        move_to(browser, 0.9)
        assert browser.find_element(By.ID, "time-shown").text == "900.0 ms"
        assert np.abs(pixels(browser) - start).max() > 0.3
        move_to(browser, 0.0)
        assert np.abs(pixels(browser) - start).max() < 0.02
        browser.find_element(By.CSS_SELECTOR, "[data-view=angle]").click()

    def test_corners_are_lit_when_they_land(self, browser, truth):
        browser.execute_script("document.getElementById('pace').value = '100'")
        quiet = np.ones(len(truth.times), bool)
        for landed in truth.landings[:, 0]:
            quiet &= (truth.times < landed - 1e-3) | (truth.times > landed + 0.25 / 100 + 1e-3)
        quiet &= ~truth.closed.any(axis=1)
        dark = float(truth.times[np.argmax(quiet)])
        strongest = np.argmax(np.hypot(truth.landings[:, 2], truth.landings[:, 3]))
        move_to(browser, dark)
        assert orange(pixels(browser)) == 0
        move_to(browser, float(truth.landings[strongest, 0]) + 1e-5)
        assert orange(pixels(browser)) > 50

    def test_it_plays_at_its_pace_and_pauses(self, browser):
        browser.execute_script("document.getElementById('pace').value = '3'")
        move_to(browser, 0.0)
        button = browser.find_element(By.ID, "play")
        button.click()
        assert button.text == "pause"
        WebDriverWait(browser, 30).until(lambda _: shown_ms(browser) > 20.0)
        button.click()
        assert button.text == "play"
        reached = shown_ms(browser)
        assert 20.0 < reached < 1000.0
        time.sleep(0.2)
        assert browser.find_element(By.ID, "time-shown").text == f"{reached:.1f} ms"

    def test_it_stops_at_the_end_and_starts_over(self, browser):
        browser.execute_script("document.getElementById('pace').value = '1'")
        move_to(browser, 0.95)
        button = browser.find_element(By.ID, "play")
        button.click()
        WebDriverWait(browser, 30).until(lambda _: button.text == "play")
        assert shown_ms(browser) == 1000.0
        browser.execute_script("document.getElementById('pace').value = '100'")
        button.click()
        time.sleep(0.3)
        button.click()
        assert shown_ms(browser) < 100.0

    def test_another_part_stands_still_and_says_which_one_runs(self, browser):
        """Nothing jumps to another part: the run's own controls are there for its part alone."""
        move_to(browser, 0.5)
        running = pixels(browser)
        browser.find_element(By.CSS_SELECTOR, "#kinds [value=braced]").click()
        assert browser.find_element(By.ID, "shown").text.startswith("walker_t35.0_braced")
        assert np.abs(pixels(browser) - running).max() > 0.3
        assert not browser.find_element(By.ID, "play").is_displayed()
        assert not browser.find_element(By.ID, "time").is_displayed()
        back = browser.find_element(By.ID, "running")
        assert back.text == "show walker_t35.0_flexible_s0.40"
        back.click()
        assert browser.find_element(By.ID, "shown").text.startswith("walker_t35.0_flexible")
        assert browser.find_element(By.ID, "play").is_displayed()
        assert not back.is_displayed()
        assert np.abs(pixels(browser) - running).max() < 0.02

    def test_a_part_that_is_chosen_while_the_run_plays_stays(self, browser):
        move_to(browser, 0.1)
        browser.find_element(By.ID, "play").click()
        browser.find_element(By.CSS_SELECTOR, "#kinds [value=braced]").click()
        time.sleep(0.3)
        assert browser.find_element(By.ID, "shown").text.startswith("walker_t35.0_braced")
        browser.find_element(By.ID, "running").click()
        assert browser.find_element(By.ID, "play").text == "play"

    @pytest.mark.parametrize("width", [390, 768, 1280])
    @pytest.mark.parametrize("scheme", ["light", "dark"])
    def test_the_track_of_the_slider_is_long_and_seen(self, browser, width, scheme):
        """A contrast of 3 is the least that WCAG 2.2 (1.4.11) asks of controls."""
        try:
            size(browser, width)
            styled(browser, prefers_color_scheme=scheme)
            slider = browser.find_element(By.ID, "time")
            assert slider.rect["width"] > 300
            image = matplotlib.image.imread(io.BytesIO(slider.screenshot_as_png))[:, :, :3]
            height, wide = image.shape[:2]
            track, ground = image[height // 2, 3 * wide // 4], image[2, 3 * wide // 4]
            low, high = sorted((luminance(track), luminance(ground)))
            assert (high + 0.05) / (low + 0.05) > 3.0
        finally:
            styled(browser, prefers_color_scheme="light")
            browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})

    def test_nothing_complained(self, browser):
        assert [one for one in browser.get_log("browser") if one["level"] != "INFO"] == []
