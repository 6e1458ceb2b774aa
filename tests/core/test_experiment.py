"""Measurement of experiments, by a ball that falls: all that a new experiment needs stands here."""

import math
import threading
import time
from typing import NamedTuple

import numpy as np
import pytest

from walkergen.core.measure import FIRST_RUNS, MAX_RUNS, Budget, Runs, UntilError, measure
from walkergen.core.numerics.quantity import mean
from walkergen.core.scene import GRAVITY
from walkergen.core.simulation import batch
from walkergen.core.tolerance import parse_tolerance


class Ball(NamedTuple):
    """Ball let go from heights that a hand misses, stepped until it is on the ground."""

    height_mm: float = 1000.0
    sd_mm: float = 100.0
    step_s: float = 1e-3
    seed: int = 1
    pause_s: float = 0.0

    def prepare(self):
        return self.fall

    def fall(self, number, stopped, tell):
        """Time of the fall, s."""
        height = np.random.default_rng([self.seed, number]).normal(self.height_mm, self.sd_mm)
        y, v, steps = height, 0.0, 0
        while y > 0.0 and not stopped():
            y, v, steps = y + self.step_s * (v - 0.5 * GRAVITY * self.step_s), v - GRAVITY * self.step_s, steps + 1
            if self.pause_s:
                time.sleep(self.pause_s)
        tell(1.0)
        return steps * self.step_s

    def quantities(self, records):
        return [mean("fall", "s", records)._replace(bias=self.step_s)]

    def finer(self):
        return None if self.step_s < 3e-4 else self._replace(step_s=0.5 * self.step_s)


def test_a_fall_takes_the_time_of_its_closed_form():
    fall = measure(Ball(sd_mm=0.0), Runs(1)).records[0]
    assert fall - Ball().step_s <= math.sqrt(2.0 * 1000.0 / GRAVITY) <= fall
    measured = measure(Ball(), Runs(64)).quantities["fall_s"]
    low, high = measured.interval()
    assert low < math.sqrt(2.0 * 1000.0 / GRAVITY) < high


def test_threads_change_no_bit_and_first_runs_of_many_are_few():
    one, four = measure(Ball(), Runs(9), threads=1), measure(Ball(), Runs(9), threads=4)
    assert one.records == four.records
    assert measure(Ball(), Runs(3)).records == one.records[:3]
    assert len(set(one.records)) > 1
    assert measure(Ball(seed=2), Runs(9)).records != one.records


@pytest.mark.parametrize(("wanted", "halved"), [("5%", False), ("0.2%", True)])
def test_runs_are_added_and_steps_halved_until_an_error_is_met(wanted, halved):
    error = UntilError(parse_tolerance(wanted), "fall_s")
    measured = measure(Ball(sd_mm=10.0), error)
    quantity = measured.quantities["fall_s"]
    assert quantity.half_width() <= error.max_error(quantity.value)
    assert (measured.experiment.step_s < Ball().step_s) == halved
    assert measured.records == measure(measured.experiment, Runs(measured.runs)).records


def test_an_error_out_of_reach_ends():
    assert measure(Ball(), UntilError(parse_tolerance("0.01%"), "fall_s")).experiment.step_s < 3e-4
    assert measure(Ball(sd_mm=300.0, step_s=2e-3), UntilError(parse_tolerance("0.6%"), "fall_s")).runs == MAX_RUNS
    alike = measure(Ball(sd_mm=0.0), UntilError(parse_tolerance("5%"), "fall_s"))
    assert alike.runs == FIRST_RUNS


@pytest.mark.parametrize("wanted", ["1.5%", "0.8%"])
def test_few_more_runs_are_made_than_an_error_needs(wanted):
    error, more = UntilError(parse_tolerance(wanted), "fall_s"), []
    for seed in range(12):
        measured = measure(Ball(sd_mm=100.0, seed=seed), error, threads=1)
        own, runs = measured.experiment, measured.records
        enough = (
            n
            for n in range(FIRST_RUNS, len(runs) + 1)
            if (fall := own.quantities(runs[:n])[0]).half_width() <= error.max_error(fall.value)
        )
        more.append(len(runs) / next(enough))
    assert max(more) <= 1.3
    assert sum(more) / len(more) < 1.15


def test_steps_that_cannot_do_are_passed_over():
    made = []

    class Counted(Ball):
        def prepare(self):
            made.append(self.step_s)
            return self.fall

    measure(Counted(), UntilError(parse_tolerance("0.2%"), "fall_s"))
    assert made == [1e-3, 5e-4]
    measure(Counted(step_s=8e-3), UntilError(parse_tolerance("0.4%"), "fall_s"))
    assert made[2:] == [8e-3, 1e-3]


def test_a_share_of_less_than_the_floor_counts_of_the_floor():
    five = UntilError(parse_tolerance("5%"), "fall_s", floor=2.0)
    assert (five.max_error(1.0), five.max_error(None), five.max_error(-4.0)) == (0.1, 0.1, 0.2)
    assert UntilError(parse_tolerance("3 mm/s"), "speed_mm_s", floor=9.0).max_error(500.0) == 3.0


def test_a_budget_of_time_makes_as_many_runs_as_it_pays():
    slow = Ball(pause_s=1e-4, step_s=5e-2)
    assert measure(slow, Budget(0.0), threads=1).runs == FIRST_RUNS
    measured = measure(slow, Budget(0.2), threads=1)
    assert measured.runs > FIRST_RUNS
    assert measured.wall_s < 5.0


def interrupted_after(count):
    """Progress that Ctrl-C ends once so many percent are done."""

    def progress(what, done, total):
        if done >= count:
            raise KeyboardInterrupt

    return progress


@pytest.mark.parametrize("threads", [1, 3])
def test_ctrl_c_keeps_the_finished_runs(threads):
    slow = Ball(pause_s=1e-3, step_s=5e-2)
    measured = measure(slow, Runs(200), interrupted_after(5), threads)
    assert measured.partial
    assert 10 <= len(measured.records) < 200
    assert set(measured.records) <= set(measure(Ball(step_s=5e-2), Runs(200)).records)


def test_ctrl_c_before_any_run_has_finished_is_passed_on():
    with pytest.raises(KeyboardInterrupt):
        measure(Ball(pause_s=1e-3, step_s=5e-2), Runs(2), interrupted_after(0), threads=1)
    before = threading.active_count()
    with pytest.raises(KeyboardInterrupt):
        batch.run_all(Ball(pause_s=1e-3, step_s=5e-2).fall, 50, interrupted_after(4), threads=2)
    assert threading.active_count() == before


def test_what_a_run_raises_ends_the_others():
    began = []

    def fails(number, stopped, tell):
        began.append(number)
        if number == 1:
            raise ValueError("a ball is lost")
        while not stopped():
            time.sleep(1e-3)

    with pytest.raises(ValueError, match="a ball is lost"):
        batch.run_parallel(fails, range(100), threads=2)
    assert len(began) < 100
