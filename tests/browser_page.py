"""Pages in a real browser, and the page of `walkergen app` by what a person does with it."""

import copy
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.select import Select
from selenium.webdriver.support.wait import WebDriverWait

BROWSER, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
WANTED = "no chromium and chromedriver: apt-get install chromium chromium-driver"
PATIENCE_S = 420.0
"""Longest wait; a search takes 35 s on an idle machine, all else some seconds."""


def chromium(profile, *more):
    """A headless browser that logs console and network; `more`: its flags for drawing."""
    if not (BROWSER and DRIVER):
        pytest.fail(WANTED)
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for flag in (
        "--headless",
        "--no-sandbox",
        "--disable-dev-shm-usage",
        "--disable-quic",
        "--no-first-run",
        "--disable-background-networking",
        "--disable-component-update",
        "--disable-sync",
        "--window-size=1280,1000",
        f"--user-data-dir={profile}",
        *(more or ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")),
    ):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return webdriver.Chrome(options, webdriver.ChromeService(DRIVER))


def walkergen(folder, *words):
    """What a command line printed that was run in a folder and succeeded."""
    done = subprocess.run(
        [sys.executable, "-m", "walkergen", *map(str, words)], cwd=folder, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


UNFOLD = """
const outer = (element) => element.parentElement.closest('details');
for (let each = outer(arguments[0]); each; each = outer(each)) each.open = true;
"""
"""Opens the tables that hold an element."""


class Page:
    """A page of a server of its own, in a folder of its own."""

    def __init__(self, browser, folder: Path, *words, card="paper") -> None:
        self.browser, self.folder, self.words = browser, folder, words
        self.download_to("downloads")
        self.start(card)

    def download_to(self, name):
        """Let the browser put files into a folder of this name."""
        self.downloads = self.folder / name
        self.downloads.mkdir(exist_ok=True)
        behaviour = {"behavior": "allow", "downloadPath": str(self.downloads)}
        self.browser.execute_cdp_cmd("Browser.setDownloadBehavior", behaviour)

    def start(self, card="paper"):
        """Start the server and open its page."""
        self.server = subprocess.Popen(
            [sys.executable, "-m", "walkergen", "app", "--port", "0", "--no-browser", *self.words],
            cwd=self.folder,
            stdout=subprocess.PIPE,
            text=True,
        )
        line = self.server.stdout.readline()
        self.address = re.search(r"http://\S+", line)[0]
        self.open(card)

    def open_in(self, browser):
        """The same page in another browser, which its `close` ends."""
        other = copy.copy(self)
        other.browser, other.close = browser, browser.quit
        other.download_to("others")
        other.open()
        return other

    def open(self, card="paper"):
        """Open the page afresh, as a new tab does, and choose a card of the first visit."""
        self.browser.get(self.address)
        self.until(lambda: self.find("#form").text)
        if card and self.find("#welcome").is_displayed():
            self.click(f"#start-{card}")
        if card:
            self.settle()

    def stop(self):
        """End the server as Ctrl-C does."""
        self.server.terminate()
        self.server.communicate(timeout=30)

    def until(self, condition):
        """Wait for a condition of the page."""
        wait = WebDriverWait(self.browser, PATIENCE_S, 0.05)
        return wait.until(lambda _: condition())

    def settle(self):
        """Wait until the page shows what was set last."""
        self.until(lambda: self.find("#speed").text and self.find("#form").text)
        for part in ("#form", "#outlook", "#findings", "#chart"):
            self.until(lambda part=part: self.find(part).get_attribute("aria-busy") == "false")

    def find(self, selector):
        return self.browser.find_element(By.CSS_SELECTOR, selector)

    def text(self, selector):
        return self.find(selector).text

    def click(self, selector):
        element = self.find(selector)
        self.browser.execute_script(UNFOLD, element)
        self.browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", element)
        element.click()

    def control(self, key):
        """Control of a key; its table is opened."""
        element = self.find(f'[id="key-{key}"]')
        self.browser.execute_script(UNFOLD, element)
        self.browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", element)
        return element

    def type(self, key, value):
        """Write a value into a control, as a person does; a choice is chosen."""
        element = self.control(key)
        if element.tag_name == "select":
            Select(element).select_by_visible_text(value)
        else:
            element.send_keys(Keys.CONTROL, "a")
            element.send_keys(str(value), Keys.TAB)
        self.settle()

    def choose(self, selector, text):
        Select(self.find(selector)).select_by_visible_text(text)
        self.settle()

    def template(self, name):
        self.click(f'#templates button[value="{name}"]')
        self.settle()

    def drop(self, path):
        """Give the page a file, as the dialogue of its button does."""
        self.find("#file").send_keys(str(path))

    def speed(self):
        """Median speed that the sentence rounds, mm/s."""
        row = self.browser.execute_script("return document.querySelector('#masses td').textContent")
        return float(row.removesuffix(" mm/s"))

    def refusals(self):
        """Sentences next to controls, and those that belong to none."""
        selector = ".refusal:not([hidden]), #stray p"
        return [each.text for each in self.browser.find_elements(By.CSS_SELECTOR, selector)]

    def take(self, what):
        """Take a file from the page; returns its path and the lines for a shell that it shows."""
        before = set(self.downloads.iterdir())
        self.browser.execute_script("document.querySelector('#taken').textContent = ''")
        self.click(f'[data-what="{what}"]')
        self.until(lambda: "in your downloads" in self.text("#taken"))
        lines = json.loads(self.find("#taken").get_attribute("data-shells"))
        path = self.downloads / self.text("#taken").removesuffix(" is in your downloads.")
        self.until(lambda: path.exists() and path not in before)
        return path, lines

    def problems(self):
        """What the browser's console complains of, but for refusals, which a page shows."""
        messages = [entry["message"] for entry in self.browser.get_log("browser")]
        return [message for message in messages if "status of 422" not in message]


needs_browser = pytest.mark.skipif(not (BROWSER and DRIVER) and "CI" not in os.environ, reason=WANTED)
