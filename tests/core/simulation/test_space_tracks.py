"""Tracks of walkers in space: written by simulate, read by analyse, and what the summary says."""

import json

import numpy as np
import pytest

from walkergen.analysis import track_files
from walkergen.analysis.track_files import Units
from walkergen.commands.simulate import make, trajectories
from walkergen.core.errors import InputError
from walkergen.core.scene import Scene
from walkergen.core.simulation import batch, ensemble, record
from walkergen.core.simulation.plan import prepare
from walkergen.core.simulation.run import recorded_impacts, simulate
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.points import trajectory

HEADER = "frame,particle,x,y,theta,t_s,x_mm,y_mm,theta_rad,height_mm,pitch_rad,roll_rad\n"
PLANE = ("--scene", "plane-90hz", "--tilt", "10")


def silent(what, done, total):
    assert 0 <= done <= total


def read_text(tmp_path, text, units=Units()):  # noqa: B008
    path = tmp_path / "tracks.csv"
    path.write_text(text, encoding="utf-8")
    return track_files.read_tracks(path, units)


TURNING = HEADER + "".join(
    f"{n},{who},,,,{0.01 * n:g},{n},{who + 2 * n},{6.2 + 0.1 * n},8.9,0.01,0.02\n" for who in (0, 3) for n in range(3)
)


def test_a_file_with_a_heading_is_a_planes_whose_y_lies_on_the_plate(tmp_path):
    found = read_text(tmp_path, TURNING)
    assert not found.lane
    assert found.interval == pytest.approx(0.01)
    assert [track.particle for track in found.tracks] == [0, 3]
    np.testing.assert_allclose(found.tracks[1].position, [[0, 3], [1, 5], [2, 7]])
    np.testing.assert_allclose(found.tracks[0].heading, [6.2, 6.3, 6.4])  # whole turns are kept


def test_a_planes_file_as_a_lane_has_no_heading(tmp_path):
    found = read_text(tmp_path, TURNING, Units(lane=True))
    assert found.lane
    assert found.tracks[0].heading is None
    np.testing.assert_allclose(found.tracks[0].position[:, 0], [0, 1, 2])


def test_a_planes_file_needs_y_and_is_not_turned_over(tmp_path):
    with pytest.raises(InputError, match="no column 'y'"):
        read_text(tmp_path, "t_s,x_mm,theta_rad\n0,1,0\n1,2,0\n")
    with pytest.raises(InputError, match=r"y to the left of x\. Leave out y_down"):
        read_text(tmp_path, TURNING, Units(y_down=True))


def test_tracks_in_a_lane_have_a_particle_and_are_seen_from_above(run, tmp_path):
    words = ("--seconds", "0.2", "--runs", "3")
    assert run("simulate", *words, "--trajectory", "t.csv").exit_code == 0
    first = (tmp_path / "t.csv").read_text(encoding="utf-8").splitlines()[0]
    assert first.startswith("frame,particle,x,y,theta,t_s,x_mm,y_mm,theta_rad")
    found = track_files.read_tracks(tmp_path / "t.csv", Units())
    assert not found.lane
    assert [(t.particle, len(t.position)) for t in found.tracks] == [(n, 201) for n in range(3)]


def asked_of(runs=2, seconds=0.3, interval=None, **run):
    design = Design().variant(tilt_deg=10.0)
    given = {"runs": runs, "seconds": seconds, "discard_seconds": 0.05} | run
    scene = Scene.model_validate({"arena": {"kind": "plane"}, "run": given})
    return make.make_walker(scene, design, solids.mass_of(design), interval)


@pytest.mark.slow
def test_tracks_are_the_same_bytes_on_any_number_of_threads():
    one = asked_of(runs=3, interval=0.002)
    plan = prepare(one.scene, one.design, one.mass)
    written = []
    for threads in (1, 3):
        results = batch.run_all(
            ensemble.runner(plan, one.impacts, one.sample_interval), plan.scene.run.runs, threads=threads
        )
        found = trajectory.from_runs(results)
        written.append(trajectory.to_csv(trajectories.with_film_columns(found, one.sample_interval)))
    assert written[0] == written[1]
    assert written[0].startswith(HEADER.encode())
    assert written[0].count(b"\n") == 1 + 3 * 151


@pytest.mark.slow
def test_keeping_impacts_changes_no_bit_of_a_run():
    one = asked_of()
    plan = prepare(one.scene, one.design, one.mass)
    plain, kept = simulate(plan, 0), simulate(plan, 0, event_room=10_000)
    np.testing.assert_array_equal(plain.places, kept.places)
    assert len(recorded_impacts(kept)) == plain.tally.counts[record.IMPACTS] > 100


@pytest.mark.slow
def test_landings_kept_are_those_counted():
    found = make.measure(asked_of(), silent)
    counts = sum(result.tally.counts for result in found.results.results)
    assert sum(one.corners.sum() for one in found.landings) == counts[record.IMPACTS]
    rows = np.concatenate([recorded_impacts(result) for result in found.results.results])
    impulses = sum(result.tally.sums[record.IMPULSES :] for result in found.results.results)
    for kind in record.KINDS.values():
        own = rows[rows[:, 6] == kind]
        assert len(own) == counts[record.count_row(kind)]
        assert impulses[record.count_row(kind)] == pytest.approx(own[:, 3].sum(), rel=1e-9)
    assert sum(one.alone + one.edges.sum() for one in found.landings) > 0
    # All landings together carry the walker's weight, but for the change of its momentum.
    weight = 9806.65 * prepare(*asked_of()[:3]).world.walker.mass
    weight *= sum(one.duration for one in found.landings)
    assert impulses[1:].sum() == pytest.approx(weight, rel=0.05)


@pytest.mark.slow
def test_analyse_finds_the_numbers_of_simulate_in_its_tracks(run):
    words = (*PLANE, "--seconds", "2", "--runs", "10", "--rate-hz", "500", "--trajectory", "t.csv")
    told = json.loads(run("simulate", *words, "--json").stdout)
    found = json.loads(run("analyse", "t.csv", "--json", "--no-pictures").stdout)
    assert (told["tip_radius_um"], told["friction"]) == (5.0, 0.25)
    for name in ("speed", "lane_speed", "sideways_speed", "turning_bias", "rotational_diffusion"):
        unit = {"turning_bias": "rad_s", "rotational_diffusion": "rad2_s"}.get(name, "mm_s")
        # The same functions on the same samples, but for the rounding of written times; the time for which
        # turning lasts, and diffusion with it, is where least squares stop.
        near = 1e-3 if name == "rotational_diffusion" else 1e-6
        assert found[f"{name}_{unit}"] == pytest.approx(told["motion"][f"{name}_{unit}"], rel=near)
    # The mean over blocks projects 44 ms at a time, not 2 ms: far below the error of either.
    error = told["speed_se_mm_s"]
    assert abs(found["speed_mm_s"] - told["speed_mm_s"]) < 0.2 * error
    assert 0 < error < 0.1 * told["speed_mm_s"]
    assert found["speed_se_mm_s"] == pytest.approx(error, rel=0.1)
    assert abs(found["lag_s"] - 0.04) < 1e-9
    for name in ("parallel", "orthogonal"):
        at, density = np.array([(b["mm"], b["density_per_mm"]) for b in found[name]]).T
        assert (density * np.gradient(at)).sum() == pytest.approx(1.0, abs=0.02)
    exponents = [b["exponent"] for b in found["msd"] if b["exponent_se"] is not None]
    assert len(exponents) > 10
    assert abs(np.median(exponents) - 2.0) < 0.1  # ballistic at 10 deg


@pytest.mark.slow
def test_places_every_44_ms_give_the_numbers_of_dense_samples():
    one = asked_of(runs=8, seconds=1.5, interval=0.002)
    dense = make.measure(one, silent)
    coarse = make.analyse_point(dense.results, one._replace(sample_interval=None))
    for name in ("speed", "sideways_speed", "turning_bias"):
        fine, rough = (found.motion.estimates[name] for found in (dense, coarse))
        assert abs(fine.value - rough.value) < 0.3 * fine.se, name  # of one and the same motion
        assert rough.se == pytest.approx(fine.se, rel=0.2)


@pytest.mark.slow
def test_the_summary_names_the_contact_and_every_unknown_has_its_reason(run):
    text = " ".join(run("simulate", *PLANE, "--seconds", "1", "--runs", "2", "--all").stdout.split())
    assert "contact tips of 5 um, restitution 0.8, friction 0.25" in text
    for words in ("along the heading", "turning scatter not resolved", "impulse of type I ", "edge"):
        assert words in text, words
    short = " ".join(run("simulate", *PLANE, "--seconds", "0.05", "--runs", "2", "--all").stdout.split())
    assert "motion unknown: runs of 0.05 s are too short; at least 0.1 s" in short


def test_a_summary_has_eight_lines_unless_all_numbers_are_requested(run):
    short = run("simulate", *PLANE, "--seconds", "1", "--runs", "2").stdout
    names = [line[2:].partition("  ")[0] for line in short.splitlines() if line[2:3].strip()]
    assert names[:4] == ["walker", "plate", "contact", "mean speed"]
    assert "runs" in names
    assert len(names) <= 9  # "--all: ..." is the last
    assert "impacts" not in names
    whole = run("simulate", *PLANE, "--seconds", "1", "--runs", "2", "--all").stdout
    assert len(whole.splitlines()) > 2 * len(short.splitlines())
