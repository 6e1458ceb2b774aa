"""How often the bounds of `analyse` hold the truth: walkers of many kinds with known numbers.

A cell is a kind of walker, a number of them, a length of the film and its gaps; or one walker in a box, whose
walls are given. Every cell has films of its own, each with new walkers
(tests/synthetic_tracks.py, tests/boxed_tracks.py), and a line of the CSV for every quantity: how often it was
estimated, and how often the truth lay inside its bounds of 68 and 95 %. Equal calls give equal lines. A second call
goes on where the first ended, unless the code of the analysis has changed since.

    python benchmarks/tracks.py [--films 200] [--seed 1] [--out out/tracks.csv] [--kind box]

200 films a cell take an hour and a half of one free core. It ends with tables
of all cells and a list of those that miss the goal.
"""

import argparse
import csv
import hashlib
import itertools
import math
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from boxed_tracks import Boxed  # noqa: E402
from boxed_tracks import films as boxed_films  # noqa: E402
from synthetic_tracks import Walker, film  # noqa: E402

from walkergen.analysis import motion, walls  # noqa: E402
from walkergen.analysis.tracks import Tracks  # noqa: E402
from walkergen.cli import console  # noqa: E402
from walkergen.core.dish import OPEN_GROUND, Dish  # noqa: E402
from walkergen.core.files.tables import csv_text  # noqa: E402

ACTIVE = Walker(lost=0.0)
KINDS = {
    "active": ACTIVE,
    "chiral": ACTIVE._replace(turn=2.0, drift=3.0),
    "inertial": ACTIVE._replace(inertia=0.1, turn_memory=0.15),
    "jittering": ACTIVE._replace(diffusion=20.0),
    "unlike": ACTIVE._replace(speed_sd=5.0, turn_sd=0.5),
}
NUMBERS = (1, 3, 8)
LENGTHS = (10.0, 40.0)
GAPS = {"none": (0.0, 0.0), "random": (0.3, 0.0), "blocks": (0.3, 25.0)}
"""Share of the frames that are lost, and mean length of a gap, frames."""

BUG = Boxed(290.0, 3.0, (800.0, 450.0), noise=0.5)
BOXES = {
    **{f"box of a bug {seconds:g} s": (BUG, seconds) for seconds in (60.0, 300.0, 861.0)},
    "box of 150 mm": (Boxed(), 300.0),
    **{f"box of {lengths}": (Boxed(box=(120.0 * lengths, 120.0 * lengths)), 300.0) for lengths in (5, 2, 1)},
    "box of 20": (Boxed(60.0, 0.3, (400.0, 400.0)), 200.0),
    "box with noise": (Boxed(60.0, 2.0, (300.0, 300.0), noise=1.0), 200.0),
    "box of a slow one": (Boxed(30.0, 0.5, (300.0, 200.0)), 120.0),
}
"""A walker in a box of so many persistence lengths, and the length of the film, s."""

WALLS = ("slide", "turn", "mirror")
"""What a wall does to a walker."""

INTERVAL = 0.04
"""Time between frames, s."""

LEVELS = (0.68, 0.95)
GOAL = (0.92, 0.98)
"""Share of truths inside bounds of 95 % that a cell should have."""

FEWEST = 10
"""Number of films of a cell with a number, below which its share says nothing."""


class Cell(NamedTuple):
    """Films of one kind."""

    kind: str
    walkers: int
    seconds: float
    gaps: str


class Row(NamedTuple):
    """Counts of one quantity in the films of a cell; the field names are the CSV's columns."""

    code: str
    """Digest of the analysis and of the walkers."""
    seed: int
    kind: str
    walkers: int
    seconds: float
    gaps: str
    quantity: str
    films: int
    told: int
    """Films whose number was not refused."""
    inside_68: int
    inside_95: int

    @property
    def cell(self) -> Cell:
        """Cell that the row belongs to."""
        return Cell(self.kind, self.walkers, self.seconds, self.gaps)


CELLS = [Cell(*values) for values in itertools.product(KINDS, NUMBERS, LENGTHS, GAPS) if values[:2] != ("unlike", 1)]
CELLS += [
    Cell(f"{box}, {wall}", 1, seconds, gaps)
    for box, (_, seconds) in BOXES.items()
    for wall, gaps in itertools.product(WALLS, ["no headings", "headings"])
]
"""All cells; one walker does not show how walkers differ. Those in boxes lose 5 % of the frames."""


def truth(walker: Walker) -> dict[str, float]:
    """Numbers that the analysis should find, by its own names: those of all prints of a kind."""
    numbers = {
        "speed": walker.ahead.real,
        "sideways speed": walker.ahead.imag,
        "turning bias": walker.turn,
        "rotational diffusion": walker.rate,
        "persistence rate": walker.rate,
        "diffusivity": _diffusivity(walker),
    }
    if walker.speed_sd:
        numbers |= {"speed scatter": walker.speed_sd, "turning scatter": walker.turn_sd}
    if walker.diffusion:
        numbers["translational diffusion"] = walker.diffusion
    return numbers


def _diffusivity(walker: Walker) -> float:
    """Mean diffusivity of walkers that differ, by Gauss and Hermite's rule."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(15)
    each = (
        [
            walker._replace(speed=walker.speed + x * walker.speed_sd, turn=walker.turn + y * walker.turn_sd).diffusivity
            for x in nodes
            for y in nodes
        ]
        if walker.speed_sd
        else [walker.diffusivity] * len(nodes) ** 2
    )
    return float(np.outer(weights, weights).ravel() @ each / weights.sum() ** 2)


def make_tracks(cell: Cell, films: int, seed: int) -> tuple[Iterable[Tracks], dict[str, float]]:
    """Films of a cell, and the numbers that are to be found in them."""
    box, _, wall = cell.kind.partition(", ")
    if box in BOXES:
        boxed, headed = BOXES[box][0]._replace(wall=wall), cell.gaps == "headings"
        known = {
            "speed": boxed.speed,
            "persistence rate": 1.0 / boxed.persistence,
            "persistence time": boxed.persistence,
        }
        if headed:
            known["rotational diffusion"] = 1.0 / boxed.persistence
        return boxed_films((seed, CELLS.index(cell)), films, cell.seconds, boxed, headed), known
    share, gap = GAPS[cell.gaps]
    walker = KINDS[cell.kind]._replace(lost=share, gap=gap)
    drawn = ((seed, CELLS.index(cell), number) for number in range(films))
    return (film(each, cell.walkers, cell.seconds, walker, INTERVAL) for each in drawn), truth(walker)


def measure_cell(cell: Cell, films: int, code: str, seed: int) -> list[Row]:
    """Count for each quantity of a cell how often it is estimated, and how often its bounds hold the true value."""
    tracks, known = make_tracks(cell, films, seed)
    counts = {name: [0, 0, 0] for name in known}
    box = cell.kind.partition(", ")[0]
    dish = Dish("rectangle", BOXES[box][0].box) if box in BOXES else OPEN_GROUND
    for each in tracks:
        found = motion.analyse(each, found_walls=walls.find_walls(each, dish)).estimates
        for name, expected in known.items():
            bounds = [found[name.replace(" ", "_")].interval(level) for level in LEVELS]
            inside = [ends is not None and ends[0] <= expected <= ends[1] for ends in bounds]
            for place, counted in enumerate((bounds[0] is not None, *inside)):
                counts[name][place] += counted
    return [Row(code, seed, *cell, name, films, *counted) for name, counted in counts.items()]


def digest() -> str:
    """Digest of everything that decides a row."""
    files = [
        *(ROOT / "walkergen" / "analysis").glob("*.py"),
        ROOT / "tests/synthetic_tracks.py",
        ROOT / "tests/boxed_tracks.py",
        ROOT / "walkergen/core/numerics/quantity.py",
        ROOT / "walkergen/core/numerics/statistics.py",
        Path(__file__),
    ]
    return hashlib.sha256(b"".join(one.read_bytes() for one in sorted(files))).hexdigest()[:12]


def read_rows(path: Path, code: str, seed: int, films: int) -> list[Row]:
    """Rows of earlier calls with the same code, seed and number of films."""
    if not path.exists():
        return []
    with path.open(encoding="utf-8", newline="") as stream:
        rows = [
            Row(
                one["code"],
                int(one["seed"]),
                one["kind"],
                int(one["walkers"]),
                float(one["seconds"]),
                one["gaps"],
                one["quantity"],
                *(int(one[name]) for name in Row._fields[7:]),
            )
            for one in csv.DictReader(stream)
        ]
    return [row for row in rows if (row.code, row.seed, row.films) == (code, seed, films)]


def share(rows: Sequence[Row]) -> str:
    """Shares inside 68 and 95 %, with the error of the latter, and what was refused, in percent."""
    estimated, films = (sum(getattr(row, name) for row in rows) for name in ("told", "films"))
    if estimated < FEWEST:
        return "refused" if films else ""
    narrow, wide = (sum(getattr(row, name) for row in rows) / estimated for name in ("inside_68", "inside_95"))
    refused = 100 * (films - estimated) / films
    note = f" ({refused:.0f})" if refused >= 0.5 else ""
    return f"{100 * narrow:.0f}, {100 * wide:.0f} ± {100 * error(wide, estimated):.0f}{note}"


def error(share: float, count: int) -> float:
    """Compute the standard error of a share of a count, with one more inside and one more outside (Agresti)."""
    shrunk = (share * count + 1.0) / (count + 2.0)
    return math.sqrt(shrunk * (1.0 - shrunk) / (count + 2.0))


def table(rows: Sequence[Row], across: str, names: Iterable[str]) -> str:
    """Markdown table of shares: quantities down, and a field of the cells across."""
    values = list(dict.fromkeys(getattr(row, across) for row in rows))
    heads = [f"{value:g} s" if across == "seconds" else str(value) for value in values]
    lines = [["", *heads], ["---"] * (len(values) + 1)]
    for name in names:
        mine = [row for row in rows if row.quantity == name]
        lines.append([name, *(share([r for r in mine if getattr(r, across) == v]) for v in values)])
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def list_failures(rows: Sequence[Row]) -> list[str]:
    """Cells whose share of 95 % lies outside the goal by more than two of its errors."""
    lines = []
    for row in rows:
        if row.told < FEWEST:
            continue
        inside = row.inside_95 / row.told
        slack = 2.0 * error(inside, row.told)
        if not GOAL[0] - slack <= inside <= GOAL[1] + slack:
            cell = row.cell
            lines.append(
                f"- {row.quantity}: {cell.kind}, {cell.walkers} walkers, "
                f"{cell.seconds:g} s, gaps {cell.gaps}: {share([row])}"
            )
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--films", type=int, default=200, help="of each cell")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", default="", help="of the cells: all whose kind has this in its name")
    parser.add_argument("--out", type=Path, default=Path("out/tracks.csv"))
    options = parser.parse_args()
    code = digest()
    rows = read_rows(options.out, code, options.seed, options.films)
    done = {row.cell for row in rows}
    options.out.parent.mkdir(parents=True, exist_ok=True)
    with console.progress("tracks", wanted=True) as progress:
        cells = [cell for cell in CELLS if options.kind in cell.kind]
        for number, cell in enumerate(cells):
            progress(" ".join(map(str, cell)), number, len(cells))
            if cell in done:
                continue
            new = measure_cell(cell, options.films, code, options.seed)
            rows += new
            text, first = csv_text(Row._fields, new), not options.out.exists()
            with options.out.open("a", encoding="utf-8", newline="") as stream:
                stream.write(text if first else text.partition("\n")[2])
    names = list(dict.fromkeys(row.quantity for row in rows))
    print(f"{options.films} films a cell, code {code}: inside 68 %, inside 95 % (refused %)")
    free = [row for row in rows if row.kind in KINDS]
    for across in ("kind", "walkers", "seconds", "gaps") if free else ():
        print(f"\n{table(free, across, names)}")
    for sight in ("no headings", "headings"):
        print(f"\n{table([row for row in rows if row.gaps == sight], 'kind', names)}")
    lines, counted = list_failures(rows), sum(row.told >= FEWEST for row in rows)
    print(f"\n{len(lines)} of {counted} miss {100 * GOAL[0]:.0f} to {100 * GOAL[1]:.0f} %:")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
