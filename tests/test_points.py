"""Points: pure functions of what is asked, the same from any executor, named by a key."""

import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

from walkergen.scene import Scene
from walkergen.simulation import experiments
from walkergen.simulation.experiments import Experiment
from walkergen.walker import solids
from walkergen.walker.design import Design

SHORT = {"seconds": 0.2, "discard_seconds": 0.0, "runs": 2}


def silent(what, done, total):
    assert 0 <= done <= total


def asked_of(tilt=10.0, impacts=False, **tables):
    design = Design().variant(tilt_deg=tilt)
    scene = Scene.model_validate({"run": SHORT} | tables)
    return Experiment(scene, design, solids.mass_of(design), impacts)


def numbers(point):
    """All numbers of a point but the time it took."""
    return [
        (
            result.number,
            result.outcome,
            result.speed,
            result.block_speeds.tolist(),
            result.energy_error,
            result.tally.counts.tolist(),
            result.tally.sums.tolist(),
        )
        for result in point.results
    ]


def test_what_is_asked_and_what_comes_back_survive_a_pickle():
    asked = asked_of(impacts=True)
    again = pickle.loads(pickle.dumps(asked))
    assert experiments.key(again) == experiments.key(asked)
    point = experiments.measure(asked, silent)
    copy = pickle.loads(pickle.dumps(point))
    assert numbers(copy) == numbers(point)
    assert (copy.key, copy.model, copy.method) == (experiments.key(asked), "space", "step")
    events = [result.tally.events.rows for result in (point.results[0], copy.results[0])]
    np.testing.assert_array_equal(*events)


@pytest.mark.slow
def test_another_process_gives_the_same_bits():
    asked = [asked_of(tilt) for tilt in (5.0, 15.0)]
    here = list(experiments.each(asked, ["5", "15"], silent, None))
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        there = list(experiments.each(asked, ["5", "15"], silent, pool))
    assert [numbers(point) for point in here] == [numbers(point) for point in there]
    assert [point.key for point in here] == [point.key for point in there]


def test_a_key_names_every_input_and_no_name():
    keys = {
        experiments.key(asked_of()),
        experiments.key(asked_of(tilt=10.0000001)),
        experiments.key(asked_of(impacts=True)),
        experiments.key(asked_of(contact={"friction": 0.3})),
        experiments.key(asked_of(run=SHORT | {"seed": 2})),
        experiments.key(asked_of()._replace(mass=asked_of().mass._replace(M=0.8))),
    }
    assert len(keys) == 6
    renamed = asked_of(name="other", description="the same", prediction={"impact_speed_factor": 2.0})
    assert experiments.key(renamed) in keys


def test_a_key_follows_the_kernels(monkeypatch):
    before = experiments.key(asked_of())
    monkeypatch.setattr("walkergen.numerics.kernels.digest", lambda: "another")
    assert experiments.key(asked_of()) != before


def test_half_a_point_is_never_given(monkeypatch):
    whole = experiments.measure(asked_of(), silent)
    half = whole._replace(summary=whole.summary._replace(runs=1))
    monkeypatch.setattr(experiments, "measure", lambda *words: half)
    with pytest.raises(KeyboardInterrupt):
        list(experiments.each([asked_of()], ["10"], silent, None))


def test_progress_goes_through_all_points():
    seen = []
    asked = [asked_of(), asked_of(tilt=12.0)]
    list(experiments.each(asked, ["one", "two"], lambda *told: seen.append(told), None))
    assert {what for what, _, _ in seen} == {"one", "two"}
    shares = [done / total for _, done, total in seen]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
