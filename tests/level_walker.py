"""A relaxed walker that stands level, moving with the plate."""

from walkergen.simulation import drive as plates
from walkergen.simulation.relaxed import walker as walkers


def level_state(walker, plate, phase=0.0, gap=0.0):
    """Level, both feet `gap` (mm) over the plate and moving with it; the plate's phase in rad."""
    pitch = walkers.level_pitch(walker)
    state = walkers.new_state(walker, plate, gap, pitch, phase)
    state[walkers.V_Y] = plates.velocity(plate, phase)
    return state
