"""The page of `walkergen app` in a real Chromium: time to a page, to a slider's step, and memory.

A step is timed from the event of its slider to the second frame after its speed was written.
Run: python benchmarks/app.py [--minutes 1] [--steps 40]
"""

import argparse
import contextlib
import http.client
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import trimesh
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.support.wait import WebDriverWait

START_S, STEP_MS, MESH_MS, TABS, FLAT = 3.0, 150.0, 400.0, 10, 1.1
"""Goals: time to a page (s), of a step at p95 (ms), of one of a large mesh; with ten pages open no
more than twice the time of one; growth of the server's memory."""

SETTLED_S = 3.0
"""Time until the parts slower than a step are drawn as well."""

APART_S = 0.5
"""Time between two steps, long enough to draw them; `drag_slider` requests without a pause."""

PAPER = {"walker": "koumakis2016", "scene": "lane-90hz", "printer": "prusa-mk3s"}

STEP = """
const [key, at, done] = arguments;
const range = document.querySelector(`.row[data-key="${key}"] input[type=range]`);
const begun = performance.now();
const drawn = new MutationObserver(() => {
  drawn.disconnect();
  requestAnimationFrame(() => requestAnimationFrame(() => done(performance.now() - begun)));
});
drawn.observe(document.querySelector('#speed'), { childList: true });
range.value = Number(range.min) + at * (range.max - range.min);
range.dispatchEvent(new Event('input', { bubbles: true }));
"""

DRAG = """
const [key, count, done] = arguments;
const range = document.querySelector(`.row[data-key="${key}"] input[type=range]`);
let step = 0;
const timer = setInterval(() => {
  range.value = Number(range.min) + (0.5 + 0.3 * step / count) * (range.max - range.min);
  range.dispatchEvent(new Event('input', { bubbles: true }));
  if (++step === count) { clearInterval(timer); setTimeout(done, 2000); }
}, 8);
"""


def chromium(profile):
    """Start a headless Chromium that logs its network traffic."""
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for flag in (
        "--headless",
        "--no-sandbox",
        "--disable-dev-shm-usage",
        "--disable-quic",
        "--no-first-run",
        "--disable-background-networking",
        "--window-size=1280,1000",
        f"--user-data-dir={profile}",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
    ):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"performance": "ALL"})
    browser = webdriver.Chrome(options, webdriver.ChromeService(shutil.which("chromedriver")))
    browser.set_script_timeout(120)
    return browser


def start_browser(folder):
    """Server in a folder, and the address of its page."""
    words = [sys.executable, "-m", "walkergen", "app", "--port", "0", "--no-browser"]
    server = subprocess.Popen(words, cwd=folder, stdout=subprocess.PIPE, text=True)
    return server, re.search(r"http://\S+", server.stdout.readline())[0]


def usable(browser):
    """Wait for a page that shows a speed and its form."""

    def is_shown(_):
        return all(browser.find_element(By.ID, name).text for name in ("speed", "form"))

    WebDriverWait(browser, 120, 0.01).until(is_shown)


def tilt(browser):
    """Key of the tilt's slider."""
    rows = browser.find_elements(By.CSS_SELECTOR, '.row[data-key$="tilt_deg"]')
    return rows[0].get_attribute("data-key")


def steps(browser, count):
    """Move a tilt slider `count` times and return the time of each step, ms; no position repeats."""
    places = np.random.default_rng(1).permutation(np.linspace(0.55, 0.85, count + 5))
    key, taken = tilt(browser), []
    for place in places:
        taken.append(browser.execute_async_script(STEP, key, place))
        time.sleep(APART_S)
    return np.array(taken[5:])


def quantiles(times):
    return f"p50 {np.median(times):.0f} ms, p95 {np.quantile(times, 0.95):.0f} ms"


def drag_slider(browser, count):
    """Most requests for the walker in flight during a drag, and whether the last one was drawn."""
    browser.get_log("performance")
    browser.execute_async_script(DRAG, tilt(browser), count)
    messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    flying, most, asked, last = set(), 0, 0, None
    for message in messages:
        own = message["params"].get("requestId")
        if message["method"] == "Network.requestWillBeSent":
            request = message["params"]["request"]
            if request["url"].endswith("/walker"):
                flying.add(own)
                asked, most, last = asked + 1, max(most, len(flying)), request.get("postData")
        elif message["method"] in ("Network.loadingFinished", "Network.loadingFailed"):
            flying.discard(own)
    key = tilt(browser)
    number = float(browser.find_element(By.ID, f"key-{key}").get_attribute("value"))
    drawn = json.loads(last)["document"]["values"][key] == number and not flying
    return asked, most, drawn


def large_mesh(folder):
    """STL of a body of 99 852 triangles: waves above a flat underside, 30 mm by 10 mm by 5 mm."""
    n = 158
    x, y = np.meshgrid(np.linspace(-15, 15, n), np.linspace(-5, 5, n), indexing="ij")
    places = np.column_stack([x.ravel(), y.ravel(), (5 + 0.8 * np.cos(x) * np.cos(y)).ravel()])
    vertices = np.concatenate([places, places * [1, 1, 0]])
    at = np.arange(n * n).reshape(n, n)

    def quads(a, b, c, d):
        return np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)

    top = quads(at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:])
    edge = np.concatenate([at[:-1, 0], at[-1, :-1], at[:0:-1, -1], at[0, :0:-1]])
    after = np.roll(edge, -1)
    sides = quads(edge, edge + n * n, after + n * n, after)
    faces = np.concatenate([top, top[:, ::-1] + n * n, sides])
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    assert mesh.is_volume
    path = folder / "waves.stl"
    path.write_bytes(mesh.export(file_type="stl"))
    return path, len(faces)


def memory(pid):
    """Memory of a process, MB."""
    (line,) = (each for each in Path(f"/proc/{pid}/status").read_text().splitlines() if "VmRSS" in each)
    return int(line.split()[1]) / 1e3


def measure_memory_growth(server, address, minutes):
    """Send requests for some minutes; return how many were answered, and memory (MB) after a third and at the end."""
    host, path = re.fullmatch(r"http://([^/]+)(/.*)", address).groups()
    rng, count, early = random.Random(1), 0, None
    begun = time.monotonic()
    with contextlib.closing(http.client.HTTPConnection(host)) as connection:
        while (passed := time.monotonic() - begun) < 60.0 * minutes:
            values = {
                "legs.tilt_deg": rng.uniform(0, 45),
                "body.length_mm": rng.uniform(28, 40),
                "legs.length_mm": rng.uniform(4, 8),
                "scene.contact.friction": rng.random(),
            }
            message = json.dumps({"document": PAPER | {"values": values}})
            connection.request("POST", path + ("outlook" if count % 20 == 0 else "walker"), message)
            answer = connection.getresponse()
            answer.read()
            count += answer.status == 200
            if early is None and passed > 20.0 * minutes:
                early = memory(server.pid)
    return count, early, memory(server.pid)


def print_figures(browser, folder, minutes, count):
    """Print every figure and its goal."""
    begun = time.monotonic()
    server, address = start_browser(folder)
    try:
        browser.get(address)
        usable(browser)
        print(f"from the command to a page: {time.monotonic() - begun:.2f} s (goal {START_S} s)")
        time.sleep(SETTLED_S)
        alone = steps(browser, count)
        print(f"a step of the paper's walker: {quantiles(alone)} (goal {STEP_MS:.0f} ms)")
        asked, most, drawn = drag_slider(browser, 200)
        print(f"a drag of 200 steps: {asked} requests, at most {most} in flight; last drawn: {drawn}")
        first = browser.current_window_handle
        for _ in range(TABS - 1):
            browser.switch_to.new_window("tab")
            browser.get(address)
            usable(browser)
        browser.switch_to.window(first)
        time.sleep(SETTLED_S)
        among = steps(browser, count)
        ratio = np.quantile(among, 0.95) / np.quantile(alone, 0.95)
        print(f"a step with {TABS} pages open: {quantiles(among)}, {ratio:.2f} of one (goal 2)")
        for handle in browser.window_handles:
            if handle != first:
                browser.switch_to.window(handle)
                browser.close()
        browser.switch_to.window(first)
        path, triangles = large_mesh(folder)
        browser.find_element(By.ID, "file").send_keys(str(path))
        WebDriverWait(browser, 120).until(
            lambda _: browser.find_elements(By.CSS_SELECTOR, '.row[data-key="body.mesh"]')
        )
        time.sleep(10 * SETTLED_S)
        mesh = steps(browser, max(count // 2, 10))
        print(f"a step of {triangles} triangles: {quantiles(mesh)} (goal {MESH_MS:.0f} ms)")
        browser.get("about:blank")
        number, early, late = measure_memory_growth(server, address, minutes)
        growth = late / early
        print(f"memory after {number} answers: {late:.0f} MB, {growth:.3f} of that after a third of them (goal {FLAT})")
    finally:
        server.terminate()
        server.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--steps", type=int, default=40)
    options = parser.parse_args()
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as folder:
        browser = chromium(Path(folder) / "profile")
        try:
            print_figures(browser, Path(folder), options.minutes, options.steps)
        finally:
            browser.quit()


if __name__ == "__main__":
    main()
