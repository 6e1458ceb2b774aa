"""The report page in a real browser, by what a person does with it; offline, from a file."""

import io
import json
import os
import re
import time
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from browser_page import BROWSER, DRIVER, WANTED, chromium
from report_folder import files_of, made_in, render_page
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

from walkergen.commands.family import report
from walkergen.core.numerics.quantity import Quantity
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.points.members import Simulated

TILTS = (0.0, 10.0, 35.0)

pytestmark = [
    pytest.mark.slow,
    pytest.mark.programs,
    pytest.mark.skipif(not (BROWSER and DRIVER) and "CI" not in os.environ, reason=WANTED),
]


def browser_at(page, profile, *more):
    """A headless browser that has loaded a page from its file."""
    browser = chromium(profile, *more)
    browser.set_window_size(1280, 1500)
    browser.get(page.as_uri())
    return browser


def requested(browser):
    """Addresses asked for since the last call, without those of the tab that it opens with."""
    messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    urls = [
        message["params"]["request"]["url"] for message in messages if message["method"] == "Network.requestWillBeSent"
    ]
    return [url for url in urls if not url.startswith(("chrome://", "chrome-untrusted://"))]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return made_in(tmp_path_factory.mktemp("family"), TILTS)


@pytest.fixture(scope="module")
def page(made):
    return made.folder / "report.html"


@pytest.fixture(scope="module")
def browser(page, tmp_path_factory):
    browser = browser_at(page, tmp_path_factory.mktemp("profile"))
    yield browser
    browser.quit()


def told(browser):
    """What the view says of its part, once it is drawn."""
    WebDriverWait(browser, 10, 0.05).until(lambda found: "Lines are" in found.find_element(By.ID, "told").text)
    return browser.find_element(By.ID, "told").text


def choose(browser, name):
    """Choose a part by its name, as it begins."""
    told(browser)
    (part,) = (one for one in browser.find_elements(By.CSS_SELECTOR, "#part option") if one.text.startswith(name))
    part.click()


def pixels(browser):
    """The canvas as an (height, width, 3) image, background white."""
    png = browser.find_element(By.ID, "canvas").screenshot_as_png
    return matplotlib.image.imread(io.BytesIO(png))[:, :, :3]


def coloured(image):
    """Share of pixels with a strong hue: the part, and neither plate, edges nor background."""
    return np.mean(np.ptp(image, axis=2) > 0.2)


def test_the_part_is_seen_in_the_colour_of_its_kind(browser):
    choose(browser, "walker_t10.0_flexible")
    image = pixels(browser)
    assert 0.03 < coloured(image) < 0.6
    red, _, blue = image[np.ptp(image, axis=2) > 0.2].mean(axis=0)
    assert blue > red
    choose(browser, "walker_t10.0_braced")
    image = pixels(browser)
    red, _, blue = image[np.ptp(image, axis=2) > 0.2].mean(axis=0)
    assert red > blue


def test_the_slider_runs_over_the_parts_by_keyboard_with_their_speeds(browser):
    choose(browser, "walker_t00.0_flexible")
    slider = browser.find_element(By.ID, "slide")
    assert told(browser).startswith("walker_t00.0_flexible_s0.40: stands.")
    upright = pixels(browser)
    slider.send_keys(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT)
    assert re.match(r"walker_t35.0_flexible_s0.40: \d.*mm/s\. Drag", told(browser))
    assert np.abs(pixels(browser) - upright).max() > 0.3
    slider.send_keys(Keys.END, Keys.ARROW_RIGHT)
    assert told(browser).startswith("walker_t35.0_braced")  # the last one
    assert browser.find_element(By.ID, "part").get_attribute("value") == "5"


def test_dragging_and_arrow_keys_turn_the_part(browser):
    canvas = browser.find_element(By.ID, "canvas")
    browser.find_element(By.CSS_SELECTOR, "[data-view=front]").click()
    front = pixels(browser)
    ActionChains(browser).drag_and_drop_by_offset(canvas, 120, 30).perform()
    dragged = pixels(browser)
    assert np.mean(np.abs(dragged - front)) > 0.01
    canvas.send_keys(Keys.ARROW_LEFT)
    assert np.mean(np.abs(pixels(browser) - dragged)) > 0.001
    browser.find_element(By.CSS_SELECTOR, "[data-view=front]").click()
    assert np.mean(np.abs(pixels(browser) - front)) < 0.001


def styled(browser, **features):
    """Look of the page with these features of the medium, until it is looked at otherwise."""
    media = [{"name": name.replace("_", "-"), "value": value} for name, value in features.items()]
    kind = "print" if not features else "screen"
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": kind, "features": media})


def size(browser, width):
    browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600},
    )


def test_in_the_dark_the_page_and_its_viewer_are_dark(browser):
    try:
        for scheme, dark in (("dark", True), ("light", False)):
            styled(browser, prefers_color_scheme=scheme)
            image = pixels(browser)
            assert bool(np.median(image) < 0.3) is dark
            assert coloured(image) > 0.03  # the part is seen on either ground
            lightness = browser.execute_script(
                "return [document.body, document.querySelector('#told')].map((one, i) => "
                "getComputedStyle(one)[i ? 'color' : 'backgroundColor'].match(/\\d+/g)[0] / 255)"
            )
            assert abs(lightness[0] - lightness[1]) > 0.6  # words stand out
    finally:
        styled(browser, prefers_color_scheme="light")


def reach(browser, selector):
    """Largest right edge (px) of what a selector finds, and how far the page scrolls sideways."""
    return browser.execute_script(
        "return [Math.max(...[...document.querySelectorAll(arguments[0])]"
        ".map((one) => one.getBoundingClientRect().right)), document.documentElement.scrollWidth]",
        selector,
    )


@pytest.mark.parametrize("width", [390, 768, 1280])
def test_the_print_sheet_is_unfolded_and_fits(browser, width):
    try:
        size(browser, width)
        sheet = browser.find_element(By.CSS_SELECTOR, ".sheet")
        for words in ("After the print: weigh", "infill overlap", "prusa-slicer --load"):
            assert words in sheet.text  # of what is displayed, and no other
        assert max(reach(browser, ".sheet *, img")) <= width
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@pytest.fixture(scope="module")
def simulated_page(made, tmp_path_factory):
    """The page of a family that was simulated too, whose table has the most columns."""
    runs = [Simulated(Quantity("speed", "mm_s", 55.9, 0.5, 3.0), f"{k} ok", "agree") for k in range(len(made.members))]
    walkers = [member._replace(simulated=one) for member, one in zip(made.members, runs, strict=True)]
    path = tmp_path_factory.mktemp("simulated") / "report.html"
    design, scene = templates.load("koumakis2016", "walkers", Design), templates.load("lane-90hz", "scenes", Scene)
    table = report.make_report(design, scene, "coulomb", walkers, made.folder).markdown().encode()
    path.write_text(render_page(made, files_of(made.folder) | {"family.md": table}), encoding="utf-8")
    return path


@pytest.mark.parametrize("simulated", [False, True])
def test_the_table_is_uncut_on_a_desk_and_scrolls_in_its_frame_on_a_phone(browser, page, simulated_page, simulated):
    frame = "const one = document.querySelector('#family'); return [one.scrollWidth, one.clientWidth]"
    try:
        browser.get((simulated_page if simulated else page).as_uri())
        size(browser, 1280)
        widths = browser.execute_script(frame)
        assert widths[0] == widths[1]
        size(browser, 390)
        widths = browser.execute_script(frame)
        assert widths[0] > widths[1]
        assert reach(browser, "img")[1] <= 390
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        browser.get(page.as_uri())


CONTRASTS = Path(__file__).with_name("contrasts.js").read_text(encoding="utf-8")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_text_stands_out_by_a_contrast_of_four_and_a_half(browser, scheme):
    """The least that WCAG 2.2 (success criterion 1.4.3, level AA) asks for."""
    try:
        styled(browser, prefers_color_scheme=scheme)
        browser.execute_script("for (const one of document.querySelectorAll('details')) one.open = true")
        texts = browser.execute_script(CONTRASTS)
        assert len(texts) > 100
        assert [one for one in texts if one["contrast"] < 4.5] == []
    finally:
        browser.execute_script("for (const one of document.querySelectorAll('details')) one.open = false")
        styled(browser, prefers_color_scheme="light")


def test_every_image_says_what_it_shows(browser):
    images = browser.find_elements(By.CSS_SELECTOR, "img, canvas, svg")
    assert len(images) >= 4
    for image in images:
        assert image.get_attribute("alt") or image.get_attribute("aria-label")


def test_paper_has_every_column_of_the_table(browser):
    try:
        size(browser, 688)  # 182 mm: a page of A4 between its margins
        styled(browser)
        table = browser.find_element(By.CSS_SELECTOR, "#family table").rect
        assert table["x"] + table["width"] <= 688
        assert not browser.find_element(By.ID, "canvas").is_displayed()
        assert browser.find_element(By.CSS_SELECTOR, "[alt^='Every part']").is_displayed()
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        styled(browser, prefers_color_scheme="light")


def test_a_part_is_saved_as_the_file_of_the_folder(browser, page, tmp_path):
    browser.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)})
    browser.execute_script("document.querySelector('details').open = true")
    name = "walker_t10.0_braced_s1.00.stl"
    browser.find_element(By.CSS_SELECTOR, f"[download='{name}']").click()
    until = time.monotonic() + 10.0
    while not (tmp_path / name).exists() and time.monotonic() < until:
        time.sleep(0.02)
    assert (tmp_path / name).read_bytes() == (page.parent / "stl" / name).read_bytes()


def test_nothing_was_fetched_and_nothing_complained(browser, page, simulated_page):
    """Last in the file: covers every interaction above."""
    assert [entry for entry in browser.get_log("browser") if entry["level"] != "INFO"] == []
    asked = requested(browser)
    assert page.as_uri() in asked
    own = (page.as_uri(), simulated_page.as_uri(), "data:")
    assert [url for url in asked if not url.startswith(own)] == []


def test_without_webgl_the_rest_is_shown_and_the_reason_told(page, tmp_path):
    browser = browser_at(page, tmp_path, "--disable-gpu", "--disable-3d-apis")
    try:
        assert not browser.find_element(By.ID, "canvas").is_displayed()
        assert "no WebGL" in browser.find_element(By.ID, "told").text
        assert browser.find_element(By.CSS_SELECTOR, "[alt^='Every part']").is_displayed()
    finally:
        browser.quit()
