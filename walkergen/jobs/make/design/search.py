"""Search: predictions find what can be made, simulations and an emulator what meets the wish."""

import re
from collections import Counter
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from walkergen.errors import InputError
from walkergen.jobs.make.design import lab
from walkergen.jobs.make.design.lab import Bench, Job, Trial
from walkergen.numerics import emulator
from walkergen.numerics.emulator import Emulator
from walkergen.points.point import REASON, STATUS

Array = npt.NDArray[np.float64]

WANTED = 3
"""Number of designs that are looked for."""

DISTINCT = (0.3, 0.2, 0.1)
"""Least distance of two designs, over the diagonal of the box: the first at which the wish is met
as well, for three that are nearly one are no choice; or the last."""

MET = 1.0
"""Loss (in allowed errors) up to which a wish is met."""

FIRST, NEAR = 24, 8
"""Numbers of points that begin a search: spread over what can be made, and best as predicted."""

ROUNDS, USUAL_ROUNDS = 6, 3
"""Largest number of rounds in which designs are proposed, tried and learnt from, and how many it usually takes."""

MOST_SAMPLES = 2048

SETTLED = {True: 0.5, False: 0.1}
"""Loss (in allowed errors) below which a tried design is good enough whatever else may be hoped
for, by whether it is simulated: the error of its runs is then a part of the loss."""

HOPED = 0.5
"""Gain over a tried design (in allowed errors) that a new one must promise to be tried."""

INSIDE = {True: 0.6, False: 0.95}
"""Distance from the target (in allowed errors) within which the least sensitive design is sought,
by whether designs are simulated."""

FINE = 0.05
"""Slope of the speed with friction, over the largest one seen, that costs one allowed error."""

STILL = 1e-3
"""Least error allowed of the fastest, mm/s: all may stand still."""

FAR, OUTSIDE = 1e6, 1e9
"""Losses of what is too near another design, and of what cannot be made."""


class Survey(NamedTuple):
    """Predictions of points spread over the box."""

    trials: list[Trial]
    x: Array
    """Coordinates, shape (n, keys)."""
    feasible: npt.NDArray[np.bool_]


class Search(NamedTuple):
    """What a search has seen and chosen."""

    survey: Survey
    trials: list[Trial]
    """All that was tried for the wish, in order."""
    chosen: list[Trial]
    """Best distinct ones, best first."""
    expected: list[float]
    """Emulated value of the wish's quantity at each."""


class Stages(NamedTuple):
    """Shares of a search's time at which its stages end; the last is the verification's."""

    survey: float
    first: float
    rounds: float

    def round(self, number: int) -> tuple[float, float]:
        """Begin and end of a round, from 0: of few rounds each is long, as most searches need no more."""
        begin, end = (self.rounds - (self.rounds - self.first) * 0.5**count for count in (number, number + 1))
        return begin, end


def stages(job: Job) -> Stages:
    """Stages of a search by what they cost."""
    efforts = job.efforts
    spread, close, verified = efforts if job.simulated else (None, None, None)
    costs = np.cumsum(
        [
            sample_size(job) * lab.PREDICTED_S,
            (FIRST + NEAR) * lab.cost(job, spread),
            USUAL_ROUNDS * (WANTED * lab.cost(job, close) + lab.PROPOSED_S),
            WANTED * lab.cost(job, verified),
        ]
    )
    return Stages(*(costs[:3] / costs[3]).tolist())


def survey(job: Job, bench: Bench) -> Survey:
    """Predict a sample. Raises InputError when nothing can be built and printed."""
    space = job.box.sample(sample_size(job), job.seed)
    rows = [job.box.values(job.box.place(dict(zip(space.keys, row, strict=True)))) for row in space.rows()]
    plain = job._replace(wish=job.wish._replace(calm=False))
    trials = lab.tried(plain, bench.at(0.0, stages(job).survey), rows, None, "predictions")
    turning = job.wish.way is not None  # on a slope few speeds are known without a run, and none is needed
    feasible = np.array([trial.printable if turning else trial.usable for trial in trials])
    if not feasible.any():
        raise InputError(_nothing(job, trials))
    return Survey(trials, np.array([job.box.place(row) for row in rows]), feasible)


def sample_size(job: Job) -> int:
    """Number of predictions that a search begins with."""
    return int(min(128 * 2 ** len(job.box.spans), MOST_SAMPLES))


def _nothing(job: Job, trials: Sequence[Trial]) -> str:
    """Line on a box in which nothing can be made: which limit stopped most of it, and the nearest.

    Reasons are told apart by their words, not by their numbers.
    """
    unbuilt = sum(not trial.buildable for trial in trials)
    reasons = [_reason(trial) for trial in trials]
    kinds = Counter(re.sub(r"[-+]?[0-9.]+", "#", reason) for reason in reasons)
    kind, count = kinds.most_common(1)[0]
    example = next(reason for reason in reasons if re.sub(r"[-+]?[0-9.]+", "#", reason) == kind)
    nearest = min(trials, key=lambda trial: (not trial.buildable, trial.record.get("print_errors") or 0))
    at = ", ".join(f"{key} = {value:g}" for key, value in nearest.values.items())
    return (
        f"--vary: none of {len(trials)} designs can be made on {job.printer.name} ({unbuilt} "
        f"cannot be built, {len(trials) - unbuilt} would not print); {count} by this: {example}; "
        f"the nearest is at {at}: try other ranges, or --set for what is held"
    )


def _reason(trial: Trial) -> str:
    if trial.buildable and trial.record.get("print_errors"):
        return str(trial.record["print_told"])
    reason = str(trial.record[REASON] if REASON in trial.record else trial.record[STATUS]).removeprefix("--vary: ")
    return reason if len(reason) <= 160 else reason[:157] + "..."


def search(job: Job, bench: Bench, seen: Survey) -> Search:
    """Search what the survey found to be makeable. Raises InputError when too little of it has the
    wish's quantity.
    """
    efforts = job.efforts
    first, second = (efforts.spread, efforts.close) if job.simulated else (None, None)
    shares = stages(job)
    trials = lab.tried(job, bench.at(shares.survey, shares.first), _first(job, seen), first, "first designs")
    view = _view(job, seen, trials)
    for number in range(ROUNDS):
        proposed = _proposed(view, number)
        if not proposed:
            break
        new = lab.tried(job, bench.at(*shares.round(number)), proposed, second, f"round {number + 1}")
        trials = [trial for trial in trials if trial.values not in proposed] + new
        view = _view(job, seen, trials)
    chosen = view.best()
    return Search(seen, trials, [view.usable[place] for place in chosen], [view.expected(place) for place in chosen])


def _first(job: Job, seen: Survey) -> list[dict[str, float]]:
    """Values to begin with: the sample's own first ones, and the best as predicted."""
    places = np.flatnonzero(seen.feasible)
    spread = places[:FIRST].tolist()
    speeds = np.array([trial.seen.value if trial.seen else 0.0 for trial in seen.trials])
    wished = job.wish.target if job.wish.of == "speed" else None
    worth = -speeds if wished is None else np.abs(speeds - wished)
    ordered = places[np.argsort(worth[places], kind="stable")].tolist()
    unseen = [place for place in ordered if place not in spread]
    near = _apart(seen.x, unseen, NEAR, DISTINCT[-1] * job.box.diagonal)
    rows = [seen.trials[place].values for place in [*spread, *near]]
    return list({tuple(row.values()): row for row in rows}.values())


def _apart(x: Array, ordered: Sequence[int], count: int, least: float) -> list[int]:
    """First of these places that keep a least distance from one another."""
    kept: list[int] = []
    for place in ordered:
        if len(kept) == count:
            break
        if all(np.linalg.norm(x[place] - x[other]) >= least for other in kept):
            kept.append(place)
    return kept


class View(NamedTuple):
    """What is known after some trials: emulators of the wish's numbers over the box."""

    job: Job
    usable: list[Trial]
    x: Array
    """Coordinates of the usable trials, shape (n, keys)."""
    value: Emulator
    """Emulator of the quantity, or of its logarithm."""
    slope: Emulator | None
    slope_scale: float
    """Largest slope seen, mm/s."""
    makeable: Callable[[Array], npt.NDArray[np.bool_]]
    """True where the nearest known point can be made; takes coordinates, shape (k, keys)."""
    fastest: float
    """Largest emulated value at a trial."""
    seen: tuple[float, float]
    """Least and largest value that was tried, or their logarithms."""

    def loss(self, x: Array, hope: float) -> Array:
        """Distance from the wish in errors allowed, `hope` standard deviations to the good side.

        Shape (k,) for coordinates of shape (k, keys). A target is missed by the emulator's error
        as well, whatever the hope.
        """
        wish = self.job.wish
        mean, sd = self.value(x)
        miss = np.zeros(len(x))
        if wish.target is not None:
            target, low, high = wish.target, *self.seen
            if wish.logarithmic:
                target, allowed = float(np.log(target)), wish.error.value
            else:
                allowed = min(wish.allowed(0.0), wish.allowed_of(max(abs(low), abs(high))))
                allowed = max(allowed, STILL)
            # A target far beyond all is as far as their range: else they would be all alike.
            target = min(max(target, 2.0 * low - high), 2.0 * high - low)
            miss = np.hypot(mean - target, sd) / allowed
        if self.slope is not None:
            level, error = self.slope(x)
            calm = np.maximum(np.abs(level) - hope * error, 0.0) / self.slope_scale
            missed = np.maximum(miss - INSIDE[self.job.simulated], 0.0)
            miss = 10.0 * missed + calm / FINE
        elif wish.target is None:
            miss = (self.fastest - mean - hope * sd) / max(wish.allowed(self.fastest), STILL)
        return np.asarray(miss)

    def best(self) -> list[int]:
        """Places of the best distinct trials by what is now known of them, best first."""
        loss = self.loss(self.x, 0.0)
        ordered = np.argsort(loss, kind="stable").tolist()
        for share in DISTINCT:
            chosen = _apart(self.x, ordered, WANTED, share * self.job.box.diagonal)
            if len(chosen) == WANTED and loss[chosen].max() <= MET:
                break
        return chosen

    def expected(self, place: int) -> float:
        """Emulated value of the quantity at a usable trial."""
        mean = float(self.value(self.x[place : place + 1])[0][0])
        return float(np.exp(mean)) if self.job.wish.logarithmic else mean


def _view(job: Job, seen: Survey, trials: Sequence[Trial]) -> View:
    """Emulators through the usable trials. Raises InputError when there are too few."""
    from scipy.spatial import cKDTree

    wish = job.wish
    usable = [trial for trial in trials if trial.usable]
    if len(usable) < emulator.FEWEST:
        status = next((str(trial.record[STATUS]) for trial in trials if not trial.usable), "")
        raise InputError(
            f"{wish.words}: only {len(usable)} of {len(trials)} designs tried have a "
            f"{wish.of} that is known, {emulator.FEWEST} are needed"
            + (f": {status[:200]}" if status not in ("", "ok") else f": no {wish.of} is resolved")
        )
    x = np.array([job.box.place(trial.values) for trial in usable])
    y = np.array([trial.seen.value for trial in usable if trial.seen])
    error = np.array([trial.seen.se for trial in usable if trial.seen])
    if wish.logarithmic:
        y, error = np.log(y), error / y
    value = emulator.fit(x, y, error)
    slope, scale = None, 1.0
    if wish.calm:
        slopes = [trial.slope for trial in usable if trial.slope]
        level = np.array([trend.value for trend in slopes])
        slope = emulator.fit(x, level, np.array([trend.se for trend in slopes]))
        scale = float(np.abs(level).max()) or 1.0
    places = np.vstack([seen.x, [job.box.place(trial.values) for trial in trials]])
    can = np.concatenate([seen.feasible, [trial.usable for trial in trials]])
    tree = cKDTree(places)
    with emulator.alone():
        fastest = float(value(x)[0].max())
    return View(
        job,
        usable,
        x,
        value,
        slope,
        scale,
        lambda at: can[tree.query(at)[1]],
        fastest,
        (float(y.min()), float(y.max())),
    )


def _proposed(view: View, seed: int) -> list[dict[str, float]]:
    """Values to try next: optima of the wish as emulated, each distinct from those before it.

    Where a trial is as good already, by as many runs, there is nothing to propose; none at all
    ends the search.
    """
    job = view.job
    least = job.efforts.close.runs if job.simulated else 0
    tried = [trial.values for trial in view.usable if trial.runs >= least]
    chosen: list[Array] = []
    rows = []
    for number in range(WANTED):
        share, at, hoped = _farthest(view, chosen, WANTED * seed + number)
        own = _loss(view, chosen, share, 0.0)(view.x.T)
        place = int(np.argmin(own))
        if own[place] < FAR and own[place] <= _enough(view, hoped):
            chosen.append(view.x[place])
            row = view.usable[place].values
        elif hoped >= FAR:
            break  # all that is left is too near to what was chosen
        else:
            chosen.append(at)
            row = job.box.values(at)
        if row not in tried:
            rows.append(row)
    return rows


def _enough(view: View, hoped: float) -> float:
    """Largest loss with which a trial stands as a design, rather than something new being tried.

    `hoped` is the least loss that the emulators hope for elsewhere.
    """
    if view.job.wish.target is None or view.slope is not None:
        return hoped + HOPED
    return max(SETTLED[view.job.simulated], hoped + 0.1)


def _farthest(view: View, chosen: Sequence[Array], seed: int) -> tuple[float, Array, float]:
    """Share of DISTINCT, the largest at which the wish can be hoped to be met; optimum and loss."""
    for share in DISTINCT:
        at, hoped = _optimum(view, chosen, share, seed)
        if hoped <= MET or not chosen:
            break
    return share, at, hoped


def _loss(view: View, chosen: Sequence[Array], share: float, hope: float) -> Callable[[Array], Array]:
    """Function of coordinates, shape (keys, k), for the optimiser: kept apart and makeable."""
    least = 1.05 * share * view.job.box.diagonal  # so that rounded values are apart as well

    def loss(columns: Array) -> Array:
        x = np.atleast_2d(columns.T)
        value = view.loss(x, hope)
        for other in chosen:
            short = least - np.linalg.norm(x - other, axis=1)
            value = np.where(short > 1e-12, FAR * (1.0 + short / least) + 1e-3 * value, value)
        return np.where(view.makeable(x), value, OUTSIDE)

    return loss


def _optimum(view: View, chosen: Sequence[Array], share: float, seed: int) -> tuple[Array, float]:
    """Coordinates of least loss, hoping for a standard deviation, and the loss there."""
    from scipy.optimize import differential_evolution

    wide = len(view.job.box.spans)
    with emulator.alone():
        optimum = differential_evolution(
            _loss(view, chosen, share, 1.0),
            [(0.0, 1.0)] * wide,
            popsize=15,
            maxiter=80,
            tol=1e-4,
            polish=False,
            vectorized=True,
            updating="deferred",
            rng=seed,
        )
    return np.asarray(optimum.x), float(optimum.fun)
