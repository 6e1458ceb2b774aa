"""Record of a run: sums and counts always (constant memory), samples and events on request.

The integrators' kernels fill its arrays in place. Arrays of unwanted samples or events are empty:
the same compiled kernels then skip them.
"""

import math
from typing import NamedTuple

import numpy as np

from walkergen.core.numerics import Array, Whole
from walkergen.core.numerics.kernels import kernel
from walkergen.core.theory.impact import TYPE_IV, Kind

KINDS = {kind.label: int(kind) for kind in Kind if kind}
"""Types of impacts (values of `impact.Kind`) by their names, in the order of `Tally.counts`."""

# Rows of `Tally.counts` in addition to those of KINDS: all impacts, and impacts where a foot sticks.
IMPACTS, STICKING = 0, 8
# Rows of `Tally.sums`.
ELAPSED, CONTACT_TIME, LARGEST_PITCH = 0, 1, 2
PLATE_WORK, IMPACT_LOSS, FRICTION_LOSS, DAMPING_LOSS = 3, 4, 5, 6
IMPULSES = 6  # and the row of a type of impact in `Tally.counts`


class Samples(NamedTuple):
    """States at a fixed interval: rows of (t in s, state...)."""

    rows: Array
    """Shape (n, 1 + entries of the state that are kept, its leading ones)."""
    cursor: Whole
    """Shape (1,): rows filled so far; full arrays stop filling."""
    interval: float
    """Time between samples, s."""

    @property
    def kept(self) -> bool:
        """Whether states are kept at all."""
        return len(self.rows) > 0


class Events(NamedTuple):
    """Landings: rows of t (s), number of the contact, F_x, F_y (g mm/s), v_x, v_y before, kind."""

    rows: Array
    """Shape (n, 7)."""
    cursor: Whole


class Tally(NamedTuple):
    """Record of one run."""

    counts: Whole
    """Shape (9,): all impacts, impacts of each of KINDS, and impacts where the foot sticks."""
    sums: Array
    """Shape (14,): elapsed time s, contact time s, largest |pitch| rad; energies, g mm^2/s^2: work
    of the plate or of a motor, losses (positive) to impacts, friction in lasting contact, damping
    and drag; normal impulses (g mm/s) that the feet took in landings of each of KINDS."""
    samples: Samples
    events: Events


def new_tally(
    sample_size: int = 0, duration: float = 0.0, sample_interval: float | None = None, event_room: int = 0
) -> Tally:
    """Return an empty record of a run of `duration` seconds.

    With a `sample_interval` (s), it has space for samples of the first `sample_size` entries of a state. It also has
    space for `event_room` impacts.
    """
    sample_count, interval = 0, math.inf
    if sample_interval is not None:
        sample_count, interval = int(duration / sample_interval + 1e-9) + 2, sample_interval
    samples = Samples(np.zeros((sample_count, 1 + sample_size)), np.zeros(1, np.int64), interval)
    events = Events(np.zeros((event_room, 7)), np.zeros(1, np.int64))
    return Tally(np.zeros(9, np.int64), np.zeros(14), samples, events)


def energy_error(sums: Array, energy_gain: float, initial_energy: float) -> float:
    """Return the energy that a tally's `sums` do not account for, as a share (>= 0) of the energy exchanged.

    The walker's energy was `initial_energy` at first and has grown by `energy_gain`, both in g mm^2/s^2.
    """
    work = sums[PLATE_WORK]
    losses = sums[IMPACT_LOSS] + sums[FRICTION_LOSS] + sums[DAMPING_LOSS]
    exchanged = max(abs(work), abs(losses), abs(initial_energy))
    return float(abs(energy_gain - (work - losses)) / exchanged) if exchanged else 0.0


@kernel
def count_row(kind: int) -> int:
    """Return the row of `Tally.counts` that counts impacts of a type (a value of `impact.Kind`)."""
    return kind if kind >= 0 else TYPE_IV - kind


@kernel
def tally_impact(counts, kind, sticks):
    """Add an impact to `counts` in place: to all, to its type (`impact.Kind`), and to STICKING if its foot `sticks`."""
    counts[IMPACTS] += 1
    counts[count_row(kind)] += 1
    if sticks:
        counts[STICKING] += 1


@kernel
def add_impulse(sums, kind, F_y):
    """Add F_y, the normal impulse (g mm/s) of a landing, to that of its type (`impact.Kind`) in `sums`, in place."""
    sums[IMPULSES + count_row(kind)] += F_y


@kernel
def note_event(events, t, foot, F_x, F_y, v_x, v_y, kind):
    """Append an impact to `events`, unless full. `foot`: number of the contact. Other arguments: as in `Events`."""
    row = events.cursor[0]
    if row < events.rows.shape[0]:
        events.rows[row, 0] = t
        events.rows[row, 1] = foot
        events.rows[row, 2] = F_x
        events.rows[row, 3] = F_y
        events.rows[row, 4] = v_x
        events.rows[row, 5] = v_y
        events.rows[row, 6] = kind
        events.cursor[0] = row + 1


@kernel
def next_sample_time(samples):
    """Return the time (s, since the record began) of the next sample; infinity without samples."""
    if samples.cursor[0] >= samples.rows.shape[0]:
        return np.inf
    return samples.cursor[0] * samples.interval


@kernel
def take_sample(samples, t, state):
    """Append the leading entries of a state at time t (s) as the next row of the samples."""
    row = samples.cursor[0]
    samples.rows[row, 0] = t
    for i in range(1, samples.rows.shape[1]):  # a slice would need memory, which space has not
        samples.rows[row, i] = state[i - 1]
    samples.cursor[0] = row + 1
