"""Journeys through `walkergen app` in a browser; each ends in files that a command makes too."""

import contextlib
import importlib.util
import io
import itertools
import json
import shlex
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest
import trimesh
from browser_page import Page, chromium, needs_browser, walkergen
from nightly_cases import mostly_nightly
from PIL import Image
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from walkergen.app import sentences

pytestmark = [pytest.mark.slow, pytest.mark.programs, needs_browser]

DATA = Path(__file__).parents[1] / "data"
SQUARE = '<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="10mm" viewBox="0 0 20 10"><path d="M0 0H20V10H0Z"/></svg>'  # noqa: E501


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    browser = chromium(tmp_path_factory.mktemp("profile"))
    yield browser
    browser.quit()


@pytest.fixture
def page(browser, tmp_path):
    page = Page(browser, tmp_path)
    yield page
    problems = page.problems()
    browser.get("about:blank")
    page.stop()
    assert problems == []


def made_again(page, path, lines):
    """Assert that the lines which the page shows make the same file, which `check` accepts."""
    made = page.folder / "out" / "app"
    kept = page.folder / "kept"
    for target in made.iterdir():
        if target.is_dir() and target.name != "uploads":
            shutil.move(target, kept / target.name)
    for line in lines:
        walkergen(page.folder, *shlex.split(line)[1:])
    if path.suffix == ".zip":
        with zipfile.ZipFile(path) as archive:
            files = {name: archive.read(name) for name in archive.namelist()}
    else:
        files = {path.name: path.read_bytes()}
    for name, data in files.items():
        (again,) = made.rglob(name)
        assert again.read_bytes() == data, name
    checked(page)


def checked(page):
    """Assert that `check` accepts the walker of the page's settings, and the printer's."""
    path, _ = page.take("toml")
    folder = page.folder / "settings"
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    inner = folder / "settings"
    walkergen(inner, "check", "walker.toml", "--printer", "printer.toml")


def set_range(page, key, value):
    """Drag the thumb of a control's slider to a value."""
    slider = page.control(key).find_element(By.XPATH, "../input[@type='range']")
    low, high, now = (float(slider.get_attribute(name)) for name in ("min", "max", "value"))
    wide = slider.size["width"] - 16  # of the thumb
    page.browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", slider)
    place = [round(((each - low) / (high - low) - 0.5) * wide) for each in (now, value)]
    drag = ActionChains(page.browser, duration=30).move_to_element_with_offset(slider, place[0], 0)
    drag.click_and_hold()
    for _ in range(8):
        drag.move_by_offset(round((place[1] - place[0]) / 8), 0)
    drag.release().perform()
    page.settle()


def test_from_a_template_to_its_part_in_three_clicks(page):
    page.template("maker-large")
    page.click('#form [data-title="tilt"] input[type="range"]')  # its middle, 0
    page.settle()
    path, lines = page.take("stl")
    assert path.suffix == ".stl"
    made_again(page, path, lines)


def test_a_tilt_that_is_typed_gives_the_speed_of_predict(page):
    page.type("legs.tilt_deg", 7.5)
    row = walkergen(page.folder, "predict", "koumakis2016", "--tilt", "7.5")
    assert float(row.split(": ")[1].split(" ±")[0]) == pytest.approx(page.speed(), abs=0.051)  # either is rounded
    path, lines = page.take("stl")
    assert "--tilt 7.5" in lines[0]
    made_again(page, path, lines)


def test_a_slider_moves_the_walker_and_its_speed_together(page):
    before = page.speed()
    set_range(page, "legs.tilt_deg", 25.0)
    tilt = float(page.control("legs.tilt_deg").get_attribute("value"))
    assert tilt > 20.0
    assert page.find("#marker").get_attribute("aria-valuenow") == f"{tilt:g}"
    assert page.speed() < before
    path, lines = page.take("3mf")
    made_again(page, path, lines)


@pytest.mark.nightly
def test_a_drag_is_one_step_to_undo(page):
    first = page.speed()
    set_range(page, "legs.tilt_deg", 20.0)  # at all tilts its speed is known
    second = page.speed()
    assert second != first
    page.click("#undo")
    page.settle()
    assert page.speed() == first
    assert not page.find("#undo").is_enabled()
    page.find("body").send_keys(Keys.CONTROL, Keys.SHIFT, "z")
    page.settle()
    assert page.speed() == second
    made_again(page, *page.take("stl"))


@pytest.mark.nightly
def test_a_name_that_is_typed_prints_as_a_walker(page):
    page.template("name")
    page.type("body.text", "LEA")
    assert page.refusals() == []
    path, lines = page.take("plate")
    assert "body.text=LEA" in lines[0]
    made_again(page, path, lines)


@pytest.mark.nightly
def test_a_polygon_grows_by_its_points(page):
    page.choose("#shape", "polygon")
    page.type("body.points_mm", "[[-14,-7],[14,-7],[14,7],[-14,7]]")
    assert page.refusals() == []
    made_again(page, *page.take("stl"))


DISC = '<svg xmlns="http://www.w3.org/2000/svg" width="28mm" height="28mm"><circle cx="53" cy="53" r="52"/></svg>'


@pytest.mark.parametrize("drawn", [SQUARE, DISC])
def test_a_drawing_that_is_dropped_is_the_body(page, drawn):
    drawing = page.folder / "drawn.svg"
    drawing.write_text(drawn)
    page.drop(drawing)
    page.settle()
    assert page.refusals() == []
    made_again(page, *page.take("stl"))


def test_a_broken_mesh_is_refused_in_words_and_the_last_walker_stays(page):
    before = page.speed()
    broken = page.folder / "broken.stl"
    broken.write_bytes(b"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\n")
    page.drop(broken)
    page.until(page.refusals)
    assert page.speed() == before
    page.click("#undo")
    page.settle()
    assert page.refusals() == []
    made_again(page, *page.take("stl"))


def test_a_button_of_a_refusal_does_what_helps(page):
    ball = page.folder / "ball.stl"
    trimesh.creation.icosphere(subdivisions=2, radius=2.0).export(ball)
    page.drop(ball)
    refusals = page.until(page.refusals)
    assert not any("body.base" in line or "length_mm" in line for line in refusals)
    page.until(lambda: page.find("img.trouble").get_property("naturalWidth") > 300)
    page.click(".help-out")
    page.until(lambda: page.refusals() == [])
    page.settle()
    made_again(page, *page.take("stl"))


def test_the_form_has_four_groups_and_a_search(page):
    folds = [each.text for each in page.browser.find_elements(By.CSS_SELECTOR, "#form > details > summary")]
    assert folds == ["Shape", "Legs", "Plate and shaker", "Print", "All settings"]
    page.click("#search")
    page.find("#search").send_keys("wall friction")
    shown = [each for each in page.browser.find_elements(By.CSS_SELECTOR, "#form .row") if each.is_displayed()]
    assert [each.get_attribute("data-key") for each in shown] == ["scene.arena.wall_friction"]
    page.find("#search").send_keys(Keys.CONTROL, "a", Keys.BACKSPACE)
    assert page.find('[data-title="Shape"] .row').is_displayed()
    assert not page.find('[data-key="scene.arena.wall_friction"]').is_displayed()


def test_what_cannot_be_built_is_said_beside_its_control(page):
    page.type("legs.tilt_deg", 8)
    before = page.speed()
    page.type("legs.tilt_deg", 89)  # by way of 8
    row = page.find('.row[data-key="legs.tilt_deg"] .refusal')
    assert "89" in row.text
    assert "tilt_deg" not in row.text
    assert page.find('[id="key-legs.tilt_deg"]').get_attribute("aria-invalid") == "true"
    assert page.speed() == before
    page.type("legs.tilt_deg", 12)
    assert page.refusals() == []
    made_again(page, *page.take("stl"))


def test_a_run_is_started_stopped_and_started(page):
    page.type("scene.run.seconds", 200)
    page.click("#run")
    page.until(lambda: page.find("#run-bar").get_attribute("value"))
    page.click("#stop")
    assert page.text("#progress") == "stopped"
    page.type("scene.run.seconds", 1)
    page.click("#run")
    page.until(lambda: page.text("#run") == "Simulate again")
    words = ("simulate", "koumakis2016", "--seconds", 1, "--runs", 8, "--tilt", 10, "--json")
    speed = json.loads(walkergen(page.folder, *words))["speed_mm_s"]
    assert f"As designed it ran {speed:.0f}"[:-1] in page.text("#ran")
    made_again(page, *page.take("stl"))


@pytest.mark.nightly
def test_a_run_plays_as_fast_as_it_is_and_slower_on_wish(page):
    page.type("scene.run.seconds", 1)
    page.click("#run")
    page.until(lambda: page.find("#player").is_displayed())
    page.until(lambda: page.text("#play") == "Play again")
    assert page.text("#time-shown") == "3.00 s"
    page.choose("#pace", "100 times slower")
    page.click("#exaggerate")
    image = page.find("#canvas").screenshot_as_png
    page.browser.execute_script(
        "arguments[0].value = 0.5; arguments[0].dispatchEvent(new Event('input'))", page.find("#time")
    )
    assert page.text("#time-shown") == "500.0 ms"
    assert page.find("#canvas").screenshot_as_png != image
    made_again(page, *page.take("stl"))


@pytest.mark.nightly  # a crowd's kernels take two minutes of a core to compile, while the page shows its bar
def test_ten_walkers_run_in_a_dish(page):
    page.click("#crowd")
    page.until(lambda: page.find("#dish").is_displayed())
    page.until(lambda: page.text("#dish-time").startswith("5."))


@pytest.mark.nightly
def test_effects_are_measured_on_the_page(page):
    page.type("legs.tilt_deg", 12)
    page.click("#numbers summary")
    page.click("#measure-effects")
    page.until(lambda: page.find("#effects").is_displayed())
    assert page.find("#effects-picture").get_property("naturalWidth") > 300
    assert "mm/s" in page.text("#effects-rows")
    assert page.text("#effects-advice")
    page.type("legs.tilt_deg", 14)
    page.until(lambda: not page.find("#effects").is_displayed())
    assert page.problems() == []


@pytest.mark.nightly
def test_a_walker_with_a_motor_runs_on_a_table(page):
    page.template("coinbot")
    page.until(lambda: page.find("#choose-scene").get_attribute("value") == "table-motor")
    page.settle()
    assert page.refusals() == []
    page.template("maker-large")
    assert page.find("#choose-scene").get_attribute("value") == "lane-90hz"


@pytest.mark.nightly
def test_the_marker_on_the_curve_drags_the_tilt(page):
    page.until(lambda: page.find("#marker").is_displayed())
    # Where it is, for the element is another one once the curve has all of its points
    x, y = page.browser.execute_script(
        "const { x, y, width, height } = document.querySelector('#marker .touch').getBoundingClientRect();"
        "return [x + width / 2, y + height / 2];"
    )
    drag = ActionChains(page.browser, duration=30)
    drag.w3c_actions.pointer_action.move_to_location(round(x), round(y))
    drag.click_and_hold()
    for _ in range(6):
        drag.move_by_offset(8, 0)
    drag.release().perform()
    page.settle()
    tilt = float(page.control("legs.tilt_deg").get_attribute("value"))
    assert 12.0 < tilt < 25.0  # 48 pixels of some 45 degrees in 300
    assert page.find("#marker").get_attribute("aria-valuenow") == f"{tilt:g}"
    made_again(page, *page.take("stl"))


def test_a_design_outlives_a_reload_and_a_restart(page):
    page.type("legs.tilt_deg", 14)
    speed = page.speed()
    page.browser.refresh()
    page.settle()
    assert page.speed() == speed
    kept = page.folder / "out" / "app" / "kept.json"  # there from the start; a change is in it within a second
    page.until(lambda: "legs.tilt_deg" in kept.read_text())
    assert page.problems() == []
    page.browser.get("about:blank")
    page.stop()
    page.start()
    assert page.speed() == speed
    made_again(page, *page.take("stl"))


def test_a_large_mesh_without_equal_legs_gets_a_speed(page):
    radius = 10.0 + 0.1 * np.random.default_rng().random()  # of no earlier run, whose speed the cache would hold
    egg = trimesh.creation.icosphere(6, radius)
    egg.vertices *= np.where(egg.vertices[:, :1] > 0.0, 2.0, 1.2) * (1.0, 0.0, 0.0) + (0.0, 1.0, 1.0)
    large = page.folder / "egg.stl"
    egg.export(large)
    assert large.stat().st_size > 4e6
    page.drop(large)
    page.until(lambda: page.find("#short-bar").is_displayed())
    assert page.find("#short-bar").get_attribute("value") is not None  # it never moves to and fro
    page.until(lambda: "unsure" not in page.find("#speed").get_attribute("class"))
    assert "mm/s" in page.find("#speed").text


def test_an_unbuildable_walker_outlives_a_reload_with_form_and_reason(page):
    page.type("legs.tilt_deg", 89)
    page.until(page.refusals)
    page.browser.refresh()
    page.until(page.refusals)
    page.until(lambda: page.browser.find_elements(By.CSS_SELECTOR, "#form .row"))
    assert page.find("#speed").text.startswith("This walker cannot be built")
    page.click("#afresh")
    page.settle()
    assert page.refusals() == []
    assert page.speed() > 0.0


def test_a_phone_shows_all_in_one_column(page):
    page.browser.set_window_size(500, 800)  # the narrowest window; the page's own is narrower
    page.browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride", {"width": 360, "height": 740, "deviceScaleFactor": 2, "mobile": True}
    )
    page.open()
    wide = page.browser.execute_script("return document.documentElement.scrollWidth")
    assert wide <= 360
    shown = ("#stage", "#outlook-heading", "#chart", "#findings", "#form", "#crowd")
    tops = [page.find(selector).rect["y"] for selector in shown]
    assert tops == sorted(tops)
    page.type("legs.tilt_deg", 15)
    made_again(page, *page.take("stl"))
    page.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    page.browser.set_window_size(1280, 1000)


def test_the_keyboard_alone_is_enough(page):
    active = page.browser.switch_to.active_element
    for _ in range(60):
        ActionChains(page.browser).send_keys(Keys.TAB).perform()
        active = page.browser.switch_to.active_element
        if active.get_attribute("id") == "key-legs.tilt_deg":
            break
    active.send_keys(Keys.CONTROL, "a")
    active.send_keys("8")
    page.settle()
    for _ in range(200):
        ActionChains(page.browser).send_keys(Keys.TAB).perform()
        active = page.browser.switch_to.active_element
        if active.get_attribute("data-what") == "stl":
            break
    ActionChains(page.browser).send_keys(Keys.ENTER).perform()
    page.until(lambda: "in your downloads" in page.text("#taken"))
    (path,) = page.downloads.glob("*.stl")
    made_again(page, path, json.loads(page.find("#taken").get_attribute("data-shells")))


def test_the_keyboard_moves_the_marker(page):
    page.until(lambda: page.find("#marker").is_displayed())  # the curve comes after the walker
    page.find("#marker").send_keys(Keys.ARROW_RIGHT)
    page.settle()
    assert page.control("legs.tilt_deg").get_attribute("value") == "10.5"
    ActionChains(page.browser).send_keys(Keys.PAGE_UP).perform()  # it has kept the focus
    page.settle()
    assert page.control("legs.tilt_deg").get_attribute("value") == "15.5"
    made_again(page, *page.take("stl"))


@pytest.mark.nightly
def test_a_walker_of_a_wished_speed_is_found_and_taken(page):
    page.find("#wished").clear()
    page.find("#wished").send_keys("40")
    page.click("#find")
    page.until(lambda: page.browser.find_elements(By.CSS_SELECTOR, "#designs button"))
    page.click("#designs button")
    page.settle()
    assert page.speed() == pytest.approx(40.0, rel=0.3)  # what is simulated differs by so much
    made_again(page, *page.take("stl"))


@pytest.mark.nightly
def test_two_designs_stand_side_by_side(page):
    first = page.speed()
    page.click("#hold")
    page.type("legs.tilt_deg", 20)
    second = page.speed()
    assert "tilt: 20 here" in page.text("#differences")
    assert f"The other: {first:.1f} mm/s" in page.text("#other-speed")
    page.click("#swap")
    page.settle()
    assert page.speed() == first
    assert f"The other: {second:.1f} mm/s" in page.text("#other-speed")
    page.click("#release")
    assert not page.find("#other").is_displayed()
    made_again(page, *page.take("stl"))


@pytest.mark.nightly
def test_a_leg_that_the_printer_drops_is_named(page):
    page.choose("#choose-printer", "ender3")
    page.type("legs.flexible_thickness_mm", 0.2)
    assert "leg" in page.text("#findings .error, #findings .warning")
    page.click("#findings .error button")
    page.settle()
    assert page.control("legs.flexible_thickness_mm").get_attribute("value") == "0.31"
    assert not page.browser.find_elements(By.CSS_SELECTOR, "#findings .error")
    made_again(page, *page.take("plate"))


@pytest.mark.nightly
def test_legs_one_by_one_are_added_and_removed(page):
    def legs():
        tables = page.browser.find_elements(By.CSS_SELECTOR, '[data-title^="walker: legs "]')
        return len(tables)

    page.click('[data-title="walker: legs"] .bar button')
    page.settle()
    assert legs() == 2
    page.click('[data-title="walker: legs 1"] .bar button')  # another like this
    page.settle()
    assert legs() == 3
    page.click('[data-title="walker: legs 1"] .bar button:last-child')  # remove
    page.settle()
    assert legs() == 2
    made_again(page, *page.take("stl"))


def test_all_files_come_as_one_archive(page):
    page.type("legs.tilt_deg", 9)
    path, lines = page.take("zip")
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        kinds = {name.rpartition(".")[2] for name in names}
        assert {"stl", "3mf", "toml", "html", "csv"} <= kinds
        assert "settings/walker.toml" in names
    assert [line.split()[1] for line in lines] == ["export", "export", "plate", "family"]
    checked(page)


@pytest.mark.nightly
def test_two_browsers_on_one_page_have_a_walker_each(page, tmp_path, tmp_path_factory):
    with contextlib.closing(page.open_in(chromium(tmp_path_factory.mktemp("profile")))) as other:
        for tilts in ((5, 12), (7, 15)):
            for each, tilt in zip((page, other), tilts, strict=True):
                each.type("legs.tilt_deg", tilt)
        taken = [each.take("stl")[0].name for each in (page, other)]
        assert taken == ["walker_t07.0_flexible_s0.40.stl", "walker_t15.0_flexible_s0.40.stl"]
        assert page.speed() != other.speed()
        assert other.problems() == []
    kept = json.loads((tmp_path / "out" / "app" / "kept.json").read_text())["document"]
    assert kept["values"]["legs.tilt_deg"] in (7, 15)


@pytest.mark.nightly
def test_names_with_markup_are_text(browser, tmp_path):
    name = "<img src=x onerror=document.title='owned'>"
    trimesh.creation.box((28.0, 8.0, 3.0)).export(tmp_path / f"{name}.stl")
    text = f'name = "ok"\ndescription = "{name}"\n[body]\nmesh = "{name}.stl"\n'
    (tmp_path / f"{name}.toml").write_text(text)
    walkergen(tmp_path, "family", f"{name}.toml", "--tilt", "10", "--legs", "braced", "--page", "--out", "out/family")
    browser.get((tmp_path / "out" / "family" / "report.html").as_uri())
    assert browser.title == "ok · walkergen"
    assert name in browser.page_source.replace("&lt;", "<").replace("&gt;", ">")
    page = Page(browser, tmp_path, f"{name}.toml", card=None)
    page.settle()
    assert browser.title == "walkergen"
    assert page.problems() == []
    browser.get("about:blank")
    page.stop()


def test_the_page_of_the_report_is_the_commands(page):
    made_again(page, *page.take("page"))


@pytest.mark.nightly
def test_on_a_plane_a_run_tells_how_the_walker_turns(page):
    page.choose("#choose-scene", sentences.format_title("plane-90hz"))
    page.type("scene.run.seconds", 4)
    page.click("#run")
    page.until(lambda: "rad/s" in page.text("#ran"))
    made_again(page, *page.take("stl"))


def test_each_picture_of_the_first_visit_is_two_clicks_from_an_stl(browser, tmp_path):
    for card in ("paper", "name", "shape"):
        folder = tmp_path / card
        folder.mkdir()
        page = Page(browser, folder, card=None)
        if card == "shape":  # what the file dialogue of its click does
            drawing = folder / "drawn.svg"
            drawing.write_text(DISC)
            page.drop(drawing)
        else:
            page.click(f"#start-{card}")
        page.settle()
        path, _ = page.take("stl")
        assert path.stat().st_size > 600
        assert not page.find("#welcome").is_displayed()
        page.stop()


SMALL = """
return [...document.querySelectorAll('button, select, summary, input:not([type=checkbox])')]
  .filter((each) => each.checkVisibility() && each.getBoundingClientRect().height < 39.5)
  .map((each) => each.outerHTML.slice(0, 80));
"""
"""Controls that are lower than a finger needs."""


@pytest.mark.parametrize("wide", [390, 1280, 1920])
def test_walker_speed_and_files_stay_in_view_at_any_width(page, wide):
    size = {"width": wide, "height": 844, "deviceScaleFactor": 1, "mobile": wide < 500}
    page.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    try:
        page.open()
        assert page.browser.execute_script("return document.documentElement.scrollWidth") <= wide
        for scrolled in (0, 1000):
            page.browser.execute_script(f"scrollTo(0, {scrolled})")
            for selector in ("#canvas", "#speed", '#take [data-what="stl"]', "#run"):
                low = page.browser.execute_script(
                    "return document.querySelector(arguments[0]).getBoundingClientRect().bottom", selector
                )
                assert 0 < low <= 844, selector
        assert page.browser.execute_script(SMALL) == []
    finally:
        page.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@pytest.mark.parametrize(
    ("wide", "colours"), mostly_nightly(list(itertools.product((1280, 390), ("light", "dark"))), (390, "light"))
)
def test_axe_finds_nothing(page, wide, colours):
    """With all tables open."""
    (folder,) = importlib.util.find_spec("axe_playwright_python").submodule_search_locations
    axe = (Path(folder) / "axe.min.js").read_text()
    try:
        page.click("#another")
        page.browser.execute_script("for (const each of document.querySelectorAll('details')) each.open = true")
        page.browser.execute_cdp_cmd("Runtime.evaluate", {"expression": axe})  # beside the page's policy
        media = [{"name": "prefers-color-scheme", "value": colours}]
        page.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": media})
        size = {"width": wide, "height": 844, "deviceScaleFactor": 1, "mobile": wide < 500}
        page.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        looked = page.browser.execute_async_script("axe.run().then(arguments[0])")
        assert len(looked["passes"]) > 20
        assert [(each["id"], node["html"][:120]) for each in looked["violations"] for node in each["nodes"]] == []
    finally:
        page.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
        page.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


SHOWN = """
const canvas = document.querySelector('#canvas');
const copy = Object.assign(document.createElement('canvas'), {width: 64, height: 48});
const paper = copy.getContext('2d');
paper.drawImage(canvas, 0, 0, 64, 48);
return [...paper.getImageData(0, 0, 64, 48).data].filter((_, k) => k % 4 === 0);
"""
"""Red of the pixels of the 3D view as it is at that moment."""


@pytest.mark.nightly
def test_a_page_in_the_dark_prints_its_view_in_light_colours(page):
    """A copy of the view in light colours stands in its place as long as the page prints."""
    media = [{"name": "prefers-color-scheme", "value": "dark"}]
    page.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": media})
    try:
        page.open()
        before, printed, after = (
            page.browser.execute_script(f"dispatchEvent(new Event('{event}')); {SHOWN}")
            for event in ("resize", "beforeprint", "afterprint")
        )
        assert np.median(printed) > 240
        assert np.median(after) < 60
        assert np.median(before) < 60
        assert len(set(printed)) > 10  # the part is on it
    finally:
        page.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


@pytest.mark.parametrize("seconds", mostly_nightly([15, 600], 15))
def test_random_clicks_cause_no_error_and_no_empty_picture(page, seconds):
    skip = "#choose-file, #start-shape, #file"  # dialogues of the browser's own
    skip += ", #crowd, #find, #measure-effects, #take button, #take-more button" if seconds < 60 else ""
    clicks = (DATA / "app_clicks.js").read_text()
    watched = page.browser.execute_cdp_cmd(
        "Page.addScriptToEvaluateOnNewDocument", {"source": (DATA / "app_watch.js").read_text()}
    )
    try:
        for seed in range(1, 2 + seconds // 60):
            page.open()
            page.browser.set_script_timeout(600)
            assert page.browser.execute_async_script(clicks, seed, 10 * min(seconds, 60), skip) == []
    finally:
        page.browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", watched)


def test_the_first_picture_holds_a_walker(page):
    for walker in ("koumakis2016", "maker-large"):
        page.template(walker)
        page.browser.get(page.address)
        for _ in range(8):  # it is blue, and no lines of the plate are
            image = np.asarray(Image.open(io.BytesIO(page.find("#stage .frame").screenshot_as_png)), dtype=float)
            assert np.mean(image[..., 2] - image[..., 0] > 30.0) > 0.05
        page.settle()
