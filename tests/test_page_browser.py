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
from browsed import BROWSER, DRIVER, WANTED, chromium
from report_folder import files_of, made_in, rendered
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

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


def shown(browser):
    return browser.find_element(By.ID, "shown").text


def pixels(browser):
    """The canvas as an (height, width, 3) image, background white."""
    png = browser.find_element(By.ID, "canvas").screenshot_as_png
    return matplotlib.image.imread(io.BytesIO(png))[:, :, :3]


def coloured(image):
    """Share of pixels with a strong hue: the part, and neither plate, edges nor background."""
    return np.mean(np.ptp(image, axis=2) > 0.2)


def column(browser, number):
    cells = browser.find_elements(By.CSS_SELECTOR, f"#family tbody tr > :nth-child({number})")
    return [cell.get_attribute("data-value") for cell in cells]


def test_the_part_is_seen_in_the_colour_of_its_kind(browser):
    browser.find_element(By.CSS_SELECTOR, "#kinds [value=flexible]").click()
    image = pixels(browser)
    assert 0.03 < coloured(image) < 0.6
    red, _, blue = image[np.ptp(image, axis=2) > 0.2].mean(axis=0)
    assert blue > red
    browser.find_element(By.CSS_SELECTOR, "#kinds [value=braced]").click()
    image = pixels(browser)
    red, _, blue = image[np.ptp(image, axis=2) > 0.2].mean(axis=0)
    assert red > blue


def test_the_slider_runs_over_the_tilts_of_the_kind_by_keyboard(browser):
    browser.find_element(By.CSS_SELECTOR, "#kinds [value=flexible]").click()
    slider = browser.find_element(By.ID, "tilt")
    slider.send_keys(Keys.HOME)
    told = "walker_t00.0_flexible_s0.40; flexible legs, 0°: predicted 0.0 mm/s (68 %: −"
    assert shown(browser).startswith(told)
    upright = pixels(browser)
    slider.send_keys(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT)
    assert shown(browser).startswith("walker_t35.0_flexible_s0.40; flexible legs, 35°")
    assert slider.get_attribute("aria-valuetext") == "35 degrees"
    assert np.abs(pixels(browser) - upright).max() > 0.3
    slider.send_keys(Keys.ARROW_RIGHT)
    assert "legs, 35°" in shown(browser)  # the last one


def test_another_kind_keeps_the_tilt(browser):
    browser.find_element(By.CSS_SELECTOR, "#kinds [value=flexible]").click()
    browser.find_element(By.ID, "tilt").send_keys(Keys.HOME, Keys.ARROW_RIGHT)
    browser.find_element(By.CSS_SELECTOR, "#kinds [value=braced]").click()
    assert shown(browser).startswith("walker_t10.0_braced_s1.00; braced legs, 10°")


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


def test_headings_sort_by_number_and_back(browser):
    headings = browser.find_elements(By.CSS_SELECTOR, "#family thead button")
    names = [heading.text for heading in headings]
    speed = names.index("your print (mm/s)") + 1
    headings[speed - 1].click()
    values = [float(text) for text in column(browser, speed)]
    assert values == sorted(values)
    assert min(values) < 0 < max(values)
    headings[speed - 1].click()
    assert [float(text) for text in column(browser, speed)] == sorted(values, reverse=True)
    mass = names.index("m (g)") + 1  # braced legs have none: empty, last both ways
    for _ in range(2):
        headings[mass - 1].click()
        assert column(browser, mass)[-3:] == ["", "", ""]


def test_a_part_is_chosen_in_the_table_and_in_the_chart(browser):
    rows = browser.find_elements(By.CSS_SELECTOR, "#family tbody tr")
    row = next(row for row in rows if "t35.0_braced" in row.text)
    row.find_element(By.CSS_SELECTOR, ".pick").click()
    assert shown(browser).startswith("walker_t35.0_braced")
    assert "chosen" in row.get_attribute("class")
    point = browser.find_element(By.CSS_SELECTOR, ".point[data-member='1'] .touch")
    ActionChains(browser).move_to_element(point).click().perform()
    assert shown(browser).startswith("walker_t10.0_flexible")
    told = browser.find_element(By.ID, "readout").text
    assert re.match(r"flexible legs, 10°: predicted \d\d\.\d mm/s \(68 %: ", told)


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
                "return [document.body, document.querySelector('#readout')].map((one, i) => "
                "getComputedStyle(one)[i ? 'color' : 'backgroundColor'].match(/\\d+/g)[0] / 255)"
            )
            assert abs(lightness[0] - lightness[1]) > 0.6  # words stand out
    finally:
        styled(browser, prefers_color_scheme="light")


@pytest.mark.parametrize("width", [360, 390])
def test_a_phone_shows_the_speed_without_scrolling(browser, width):
    try:
        size(browser, width)
        headings = browser.find_elements(By.CSS_SELECTOR, "#family thead th")
        heading = next(one for one in headings if one.text.startswith("your print"))
        edge = heading.rect["x"] + heading.rect["width"]
        assert edge <= width
        assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


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
        sheet = browser.find_element(By.CSS_SELECTOR, ".markdown")
        for words in ("After the print: weigh", "infill overlap", "prusa-slicer --load"):
            assert words in sheet.text  # of what is displayed, and no other
        assert max(reach(browser, ".markdown *, img")) <= width
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@pytest.fixture(scope="module")
def simulated_page(made, tmp_path_factory):
    """The page of a family that was simulated too, whose table has the most columns."""
    runs = [Simulated(55.9, 0.5, 53.7, 58.1, "space", "step", f"{k} ok", "agree") for k in range(len(made.members))]
    walkers = [member._replace(simulated=one) for member, one in zip(made.members, runs, strict=True)]
    path = tmp_path_factory.mktemp("simulated") / "report.html"
    path.write_text(rendered(made, files_of(made.folder), walkers), encoding="utf-8")
    return path


@pytest.mark.parametrize("simulated", [False, True])
def test_the_table_is_uncut_on_a_desk_and_scrolls_in_its_frame_on_a_phone(browser, page, simulated_page, simulated):
    frame = "const one = document.querySelector('#family').parentNode; "
    try:
        browser.get((simulated_page if simulated else page).as_uri())
        size(browser, 1280)
        widths = browser.execute_script(frame + "return [one.scrollWidth, one.clientWidth]")
        assert widths[0] == widths[1]
        size(browser, 390)
        widths = browser.execute_script(frame + "return [one.scrollWidth, one.clientWidth]")
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
        table = browser.find_element(By.ID, "family").rect
        assert table["x"] + table["width"] <= 688
        assert not browser.find_element(By.ID, "canvas").is_displayed()
        assert browser.find_element(By.CSS_SELECTOR, "#no-viewer img").is_displayed()
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        styled(browser, prefers_color_scheme="light")


def test_the_chosen_part_is_saved_as_the_file_of_the_folder(browser, page, tmp_path):
    browser.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)})
    browser.find_element(By.CSS_SELECTOR, "#kinds [value=braced]").click()
    browser.find_element(By.CSS_SELECTOR, "#save a").click()
    name = f"{shown(browser).split(';')[0]}.stl"
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
        assert "no WebGL" in browser.find_element(By.ID, "no-viewer-reason").text
        assert browser.find_element(By.CSS_SELECTOR, "#no-viewer img").is_displayed()
        browser.find_element(By.CSS_SELECTOR, "#family th:nth-child(2) button").click()
        assert column(browser, 2) == ["0.0", "0.0", "10.0", "10.0", "35.0", "35.0"]
    finally:
        browser.quit()
