"""What a printable part costs: walkergen against the modellers one would otherwise script.

modellers.py holds the ways to make a part and says what each does. Every way runs in a process of
its own; imports are not timed, except in the last table, which times whole processes. The files
go to the temporary folder: TMPDIR=/dev/shm takes the disk out of the times.

    python benchmarks/parts.py [--repeats 5] [--rivals bare,trimesh,openscad] [--install]

CadQuery and build123d never enter the project's environment: --install puts them into a virtual
environment that is removed at the end.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from modellers import COLD_TILTS, WARM_TILTS, WAYS

MODELLERS = str(Path(__file__).with_name("modellers.py"))
PARTS = ["koumakis2016", "--tilt", "0:39.5:0.5", "--legs", "flexible,braced"]
FAMILY = ["family", *PARTS, "--no-pictures", "--quiet", "--out"]
EXPORT = ["export", *PARTS, "--quiet", "--out"]
ISOLATED = ("cadquery", "build123d")
MOST_TIMES, MOST_S = 3.0, 1.5  # of export, and in all
AGREEMENT = 1e-6  # relative; STL files hold 32-bit floats


def run_worker(python: str, way: str, repeats: int, count: int) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        command = [python, MODELLERS, way, folder, str(repeats), str(count)]
        said = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    found: dict[str, Any] = json.loads(said.splitlines()[-1])
    return found


def cold_seconds(command: list[str], repeats: int) -> list[float]:
    """Wall times of a whole process that writes all 160 parts into a new folder each time."""
    taken = []
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as folder:
            started = time.perf_counter()
            subprocess.run([*command, folder], check=True, stdout=subprocess.DEVNULL)
            taken.append(time.perf_counter() - started)
            written = len(list(Path(folder).rglob("*.stl")))
        if written != 2 * len(COLD_TILTS):
            raise SystemExit(f"{' '.join(command)}: wrote {written} parts, not 160")
    return taken


def differences(reference: dict[str, Any], rival: dict[str, Any]) -> tuple[float, float]:
    """Largest relative differences of volume and inertia over the parts that both made."""
    known = {tuple(part): weighed for part, weighed in reference["weighed"]}
    ratios = [np.divide(w, known[tuple(part)]) - 1.0 for part, w in rival["weighed"]]
    volume, inertia = np.abs(ratios).max(axis=0)
    return float(volume), float(inertia)


def isolated_python(folder: Path) -> str:
    """Create a virtual environment with the modellers that are no dependencies, and return its Python."""
    print(f"installing {' and '.join(ISOLATED)} into {folder} ...", file=sys.stderr)
    subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    subprocess.run([str(python), "-m", "pip", "install", "-qq", *ISOLATED], check=True)
    return str(python)


def machine() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    cpu = names[0] if names else platform.processor()
    return (
        f"{cpu}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}, "
        f"Python {platform.python_version()}, numpy {np.__version__}"
    )


def compare(ways: list[str], pythons: dict[str, str], options: argparse.Namespace) -> bool:
    """Print the table of warm times; True when every rival made the same parts."""
    whole = 2 * len(WARM_TILTS)
    found = {}
    # walkergen again after the rivals: a shared machine is not as fast all the time.
    for way in ["walkergen", *ways, "walkergen"]:
        count = whole if way in ("walkergen", "bare") else options.count
        earlier = found.get(way, {"per_part": []})["per_part"]
        found[way] = run_worker(pythons[way], way, options.repeats, count)
        if "skipped" not in found[way]:
            found[way]["per_part"] += earlier
    reference = found["walkergen"]
    if "skipped" in reference:
        raise SystemExit(f"walkergen: {reference['skipped']}; {WAYS['walkergen'][1]}")
    print(
        f"{'one part':<21}{'parts':>6}{'ms/part':>10}{'least..most':>20}{'ratio':>8}"
        f"{'dV/V':>10}{'dJ/J':>10}{'import s':>10}"
    )
    apart = 0.0
    for way, made in found.items():
        if "skipped" in made:
            print(f"{way:<21}skipped: {made['skipped']}; {WAYS[way][1]}")
            continue
        volume, inertia = differences(reference, made)
        apart = max(apart, volume, inertia)
        times = 1e3 * np.array(made["per_part"])
        ratio = np.median(made["per_part"]) / np.median(reference["per_part"])
        spread = f"{times.min():.3f}..{times.max():.3f}"
        print(
            f"{way + ' ' + made['version']:<21}{len(made['weighed']):>6}"
            f"{np.median(times):>10.3f}{spread:>20}{ratio:>8.2f}"
            f"{volume:>10.1e}{inertia:>10.1e}{made['imports']:>10.2f}"
        )
    return apart <= AGREEMENT


def compare_cold(repeats: int) -> None:
    """Print the wall times of whole processes: all 160 parts, imports included."""
    commands = {
        "bare script": [sys.executable, MODELLERS, "--all", "bare"],
        "walkergen export": [sys.executable, "-m", "walkergen", *EXPORT],
        "walkergen family": [sys.executable, "-m", "walkergen", *FAMILY],
    }
    print(f"\n{'a whole process':<21}{'parts':>6}{'s':>10}{'least..most':>20}{'ratio':>8}")
    taken = {name: cold_seconds(command, repeats) for name, command in commands.items()}
    family = statistics.median(taken["walkergen family"])
    for name, seconds in taken.items():
        spread, median = f"{min(seconds):.3f}..{max(seconds):.3f}", statistics.median(seconds)
        print(f"{name:<21}{160:>6}{median:>10.3f}{spread:>20}{median / family:>8.2f}")
    share = family / statistics.median(taken["walkergen export"])
    print("walkergen family also weighs the parts, packs the plates and predicts 160 speeds with")
    print(f"their bounds: {share:.2f} times export, {family:.2f} s.")
    print(f"Goals: {MOST_TIMES:g} times and {MOST_S:g} s.")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--repeats", type=int, default=5, help="medians of this many runs")
    parser.add_argument("--count", type=int, default=6, help="parts a slow rival makes per run")
    parser.add_argument("--rivals", default=",".join(list(WAYS)[1:]), help="comma-separated")
    parser.add_argument("--install", action="store_true", help="try CadQuery and build123d too")
    options = parser.parse_args()
    ways = [way for way in options.rivals.split(",") if way]
    for way in ways:
        if way not in list(WAYS)[1:]:
            parser.error(f"--rivals {way!r}: choose from {', '.join(list(WAYS)[1:])}")
    print(machine())
    with tempfile.TemporaryDirectory(prefix="walkergen-rivals-") as folder:
        pythons = dict.fromkeys(WAYS, sys.executable)
        if options.install and set(ways) & set(ISOLATED):
            pythons |= dict.fromkeys(ISOLATED, isolated_python(Path(folder)))
        agree = compare(ways, pythons, options)
    compare_cold(options.repeats)
    if not agree:
        raise SystemExit(f"the rivals made different parts: more than {AGREEMENT:g} apart")


if __name__ == "__main__":
    main()
