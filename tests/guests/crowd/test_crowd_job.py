"""The command `crowd`: who is asked for, what is refused, the folder, threads, interruptions.

Random walks stand for the simulator, whose own laws are tested elsewhere; one slow test runs it.
"""

import errno
import json
import time

import file_faults
import numpy as np
import pytest
from command_checks import rows_of

from walkergen.core.errors import InputError
from walkergen.core.files.progress import silent
from walkergen.core.scene import Scene
from walkergen.core.walker.design import Design
from walkergen.files import templates
from walkergen.guests.crowd import in_space as crowd_space
from walkergen.guests.crowd import make, walker_counts
from walkergen.guests.crowd.request import CrowdRequest
from walkergen.guests.crowd.space import placing
from walkergen.guests.crowd.space import run as crowds
from walkergen.guests.crowd.space.result import CrowdRun, Impulses


def walk(plan, number, rate_hz, stopped=lambda: False, progress=lambda seconds: None):
    """Run of walkers that stagger about their places, as fast as the machine can."""
    run, n = plan.scene.run, len(plan.kinds)
    frames = max(round(run.seconds * rate_hz), 1)
    rng = np.random.default_rng([run.seed, number, 7])
    steps = rng.normal(scale=(0.02, 0.02, 0.02), size=(frames, n, 3))
    poses = np.zeros((frames, n, 6))
    poses[..., :3] = plan.places + np.cumsum(steps, axis=0)
    outcome = "stopped" if stopped() else "ok"
    progress(run.seconds)
    return CrowdRun(
        number,
        (outcome,) * n,
        tuple(plan.names[kind] for kind in plan.kinds),
        np.arange(frames) / rate_hz,
        poses,
        10 * n,
        0.004,
        1e-4,
        1e-3,
        {"normal": 1.0, "friction": 2.0},
        Impulses(3.0, 0.5, 0.3),
        0.0,
    )


@pytest.fixture
def walking(monkeypatch):
    monkeypatch.setattr(crowds, "simulate", walk)


COMMAND = ("crowd",)
REQUEST = CrowdRequest(rate_hz=10.0, threads=1)
SHORT = ("--seconds", "2", "--runs", "4", "--no-pictures")


def population_of(names, counts, **keys):
    scene = templates.load("plane-90hz", "scenes", Scene).variant(**{"run.seconds": 1.0, "run.runs": 3, **keys})
    designs = [templates.load(name, "walkers", Design) for name in names]
    return crowd_space.make_population(REQUEST, scene, designs, counts)


def test_a_disc_with_a_hole_has_nobody_in_its_hole(tmp_path):
    ring = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60">'
        '<path fill-rule="evenodd" d="M0 30 A30 30 0 1 1 60 30 A30 30 0 1 1 0 30 Z '
        'M5 30 A25 25 0 1 1 55 30 A25 25 0 1 1 5 30 Z"/></svg>'
    )
    (tmp_path / "ring.svg").write_text(ring)
    legs = [{"along_mm": x, "across_mm": z, "width_mm": 2.0} for x in (-20.0, 20.0) for z in (-18.0, 18.0)]
    holed = Design.model_validate({"name": "holed", "legs": legs, "body": {"outline": str(tmp_path / "ring.svg")}})
    small = templates.load("polar-disc", "walkers", Design)
    scene = templates.load("plane-90hz", "scenes", Scene)
    scene = scene.variant(**{"crowd.arena_mm": "disc:61"})
    crowd = crowd_space.make_population(REQUEST, scene, [holed, small], [1, 2])
    with pytest.raises(InputError, match="do not fit"):
        make.simulate(REQUEST, crowd, silent)


def test_counts_are_numbers_or_designs_with_theirs():
    assert walker_counts.parse_walker_count(" 30 ") == 30
    both = walker_counts.parse_walker_count("polar-disc:20, my/rotator.toml:10")
    assert both == {"polar-disc": 20, "my/rotator.toml": 10}
    assert walker_counts.parse_walker_count("C:\\walkers\\mine.toml:3,b:2")["C:\\walkers\\mine.toml"] == 3


def test_one_walker_in_a_dish_is_a_crowd_of_one(run, walking):
    result = run("--count", "1", "--arena", "disc:120", *SHORT, "--json")
    assert result.exit_code == 0, result.output
    numbers = json.loads(result.stdout)["numbers"]
    assert numbers["polar_order"]["value"] == numbers["polar_order"]["by_chance"] == 1.0
    assert numbers["speed_mm_s"]["value"] > 0.0
    assert numbers["wall_density"]["value"] > 0.0
    assert numbers["local_polar_order"]["refused"] == "too few walkers"
    assert "of 1 walker in disc:120" in run("--count", "1", "--arena", "disc:120", *SHORT).stdout


def test_a_packing_says_how_many_and_the_report_how_dense():
    crowd = population_of(["koumakis2016"], None, **{"crowd.packing": 0.3, "crowd.arena_mm": "disc:200"})
    assert sum(kind.walkers for kind in crowd.kinds) == round(0.3 * np.pi * 100.0**2 / 224.0)
    assert crowd.packing == pytest.approx(0.3, rel=0.02)
    assert [kind.walkers for kind in population_of(["koumakis2016"], None).kinds] == [walker_counts.DEFAULT_COUNT]


def test_the_folder_holds_numbers_with_errors_and_every_run(run, walking, tmp_path):
    result = run("--count", "polar-disc:6,rotator:4", "--arena", "disc:200", *SHORT, "--json")
    assert result.exit_code == 0, result.output
    facts = json.loads(result.stdout)
    assert facts["kinds"] == {"polar-disc": 6, "rotator": 4}
    assert facts["runs"] == 4
    polar = facts["numbers"]["polar_order"]
    assert polar["se"] > 0.0
    folder = tmp_path / facts["folder"]
    assert {path.name for path in (folder / "tracks").iterdir()} >= {
        f"run-{number}{suffix}" for number in range(4) for suffix in (".csv", ".xyz")
    }
    rows = rows_of(folder / "tracks" / "run-1.csv")
    assert len(rows) == 10 * 50
    assert {row["particle"] for row in rows} == {str(number) for number in range(10)}
    assert "polar order" in (folder / "report.md").read_text()
    assert json.loads((folder / "manifest.json").read_text())["counts"] == [6, 4]


@pytest.mark.parametrize("pictures", [True, False])
def test_the_forecast_and_the_bar_count_the_pictures(walking, monkeypatch, tmp_path, pictures):
    monkeypatch.setattr(crowd_space, "cpu_seconds", lambda request, population: 6.0)
    told, heard = [], []
    values = {"count": 4, "seconds": 1, "runs": 2, "threads": 2, "pictures": pictures, "out": tmp_path / "dish"}
    asked = CrowdRequest.from_values(values)
    asked.register_time_callback(lambda find: heard.append(find().seconds))
    asked.run(lambda *progress: told.append(progress))
    assert heard == [6.0 + make.PICTURES_S * pictures]
    shares = [done / total for _, done, total in told]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    begun = {what: share for (what, *_), share in reversed(list(zip(told, shares, strict=True)))}
    assert begun["pictures" if pictures else "tables"] == pytest.approx(6.0 / heard[0], abs=0.01)


def test_any_number_of_threads_gives_the_same_bytes(run, walking, tmp_path):
    written = []
    for threads in ("1", "3"):
        folder = tmp_path / threads
        words = ("--count", "12", "--arena", "periodic:150", "--threads", threads)
        assert run(*words, *SHORT, "--out", str(folder), "--quiet").exit_code == 0
        files = sorted(path for path in folder.rglob("*") if path.is_file())
        written.append({path.relative_to(folder): path.read_bytes() for path in files})
    assert written[0] == written[1]


def test_every_run_begins_at_places_of_its_own_without_overlap(walking):
    crowd = population_of(["rotator", "polar-disc"], [4, 6], **{"crowd.arena_mm": "disc:150"})
    films = make.simulate(REQUEST, crowd, silent).films
    starts = [np.column_stack([film.x[0], film.y[0], film.theta[0]]) for film in films]
    assert all(np.abs(starts[0] - other).max() > 1.0 for other in starts[1:])
    outlines = {kind.design.name: kind.outline for kind in crowd.kinds}
    # The walk begins within 0.1 mm, and shows C where a simulation shows O, 0.4 mm off at most
    within = [0.95 * contour for contour in outlines["rotator"]]
    shapes = {"rotator": within, "polar-disc": [0.95 * ring for ring in outlines["polar-disc"]]}
    for film, start in zip(films, starts, strict=True):
        bodies = [shapes[kind] for kind in film.kinds]
        assert placing.find_overlap(bodies, film.dish, start) is None


def test_ctrl_c_keeps_the_runs_that_are_done_and_stops_the_others(monkeypatch):
    def slow(plan, number, rate_hz, stopped=lambda: False, progress=lambda seconds: None):
        seconds = plan.scene.run.seconds  # the first moment compiles
        while (number > 0 or seconds > 1.5) and seconds > 0.5 and not stopped():
            time.sleep(0.01)
        return walk(plan, number, rate_hz, stopped, progress)

    def interrupting(what, done, total):
        if what == "runs" and done > 0:
            raise KeyboardInterrupt

    monkeypatch.setattr(crowds, "simulate", slow)
    crowd = population_of(["polar-disc"], [4])
    simulated = make.simulate(CrowdRequest(rate_hz=10.0, threads=2), crowd, interrupting)
    assert [run.number for run in simulated.runs] == [0]

    def at_once(what, done, total):
        if what == "runs":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make.simulate(REQUEST, crowd._replace(scene=crowd.scene.variant(**{"run.seconds": 2})), at_once)


def test_a_full_disk_is_told_and_leaves_no_half_file(run, walking, tmp_path):
    folder = tmp_path / "dish"
    for number in (1, 5, 9):
        with file_faults.failing(folder, "write", number, file_faults.broken(errno.ENOSPC)) as calls:
            result = run("--count", "4", *SHORT, "--out", str(folder))
        assert len(calls) >= number
        assert "No space left" in str(result.exception)
        assert not list(folder.rglob(".*.walkergen-*"))
    assert run("--count", "4", *SHORT, "--out", str(folder)).exit_code == 0


@pytest.mark.slow
def test_walkers_in_space_are_the_same_bytes_on_any_number_of_threads(run, tmp_path):
    written = []
    for threads in ("1", "2"):
        words = ("--count", "polar-disc:3,rotator:2", "--arena", "disc:90", "--seconds", "0.4")
        more = ("--runs", "2", "--no-pictures", "--threads", threads, "--out", threads)
        result = run(*words, *more, "--json")
        assert result.exit_code == 0, result.output
        files = sorted(path for path in (tmp_path / threads).rglob("*") if path.is_file())
        written.append({path.relative_to(tmp_path / threads): path.read_bytes() for path in files})
    assert written[0] == written[1]
    facts = json.loads(result.stdout)
    assert facts["outcomes"] == {"ok": 10}
    assert facts["numbers"]["speed_mm_s"]["value"] > 1.0
    assert max(row["energy_error"] for row in facts["contacts"]) < 0.05
