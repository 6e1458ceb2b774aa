"""Worlds of planar walkers for tests of the models' own functions, without a scene."""

import math

from walkergen.jobs.trust.selftest.scenes import masses
from walkergen.scene import GRAVITY
from walkergen.simulation import record
from walkergen.simulation.compliant import state as hinged
from walkergen.simulation.compliant import steps
from walkergen.simulation.drive import Drive, velocity
from walkergen.simulation.effects import air_drag
from walkergen.simulation.effects.acting import Acting
from walkergen.simulation.effects.slope import gravity_of
from walkergen.simulation.relaxed import events
from walkergen.simulation.relaxed import state as relaxed
from walkergen.simulation.world import V_Y, Contact, World
from walkergen.walker.design import Design

STEPS = steps.Options(1e-5)
"""Options of the compliant model."""

OMEGA = 2.0 * math.pi * 90.0
ANY = Contact(0.5, 0.25, 0)


def shaken(gamma, frequency=90.0):
    omega = 2.0 * math.pi * frequency
    return Drive(gamma * GRAVITY / omega**2, omega)


SHAKEN = shaken(1.8)


def world_of(walker, drive=SHAKEN, contact=ANY, options=STEPS, slope=0.0, air=air_drag.OFF):
    """World of two feet of one `Contact`, or of a pair of them."""
    contacts = (contact, contact) if isinstance(contact, Contact) else contact
    return World(walker, drive, contacts, Acting(gravity_of(slope), air), options)


def hinged_walker(tilt, **options):
    design = Design().variant(tilt_deg=float(tilt))
    return hinged.walker_of(design, masses(design), **options)


def hinged_state(walker, clearance, pitch=0.0, phase=0.0, drive=SHAKEN):
    """At rest in the laboratory, the lower foot `clearance` mm over the plate."""
    return hinged.start(world_of(walker, drive), clearance, pitch, phase)


def relaxed_walker(tilt=0.0, flexible=False, **keys):
    """A box on two thin legs: relaxed ones, or braced ones without mass."""
    design = Design().variant(tilt_deg=tilt, kind="flexible" if flexible else "braced", **keys)
    return relaxed.walker_of(design, masses(design))


def level_state(walker, drive, phase=0.0, gap=0.0):
    """Level, both feet `gap` (mm) over the plate and moving with it; the drive's phase in rad."""
    pitch = relaxed.level_pitch(walker)
    state = relaxed.start(world_of(walker, drive), gap, pitch, phase)
    state[V_Y] = velocity(drive, phase)
    return state


def relaxed_world(walker, drive, contact, slope=0.0):
    options = relaxed.options_for(walker, drive, GRAVITY)
    return world_of(walker, drive, contact, options, slope)


def go(walker, drive, contact, state, duration, slope=0.0, tally=None):
    """Advance a relaxed walker from event to event: status and tally."""
    tally = record.new(len(state)) if tally is None else tally
    world = relaxed_world(walker, drive, contact, slope)
    return events.advance(world, state, duration, tally), tally


def unlike_design(mirrored=False, kind="flexible"):
    """Two legs that share nothing but the level of their feet; or their mirror image."""
    legs = [
        {"tilt_deg": 10.0, "length_mm": 7.5, "thickness_mm": 0.4, "along_mm": -5.0},
        {
            "tilt_deg": -5.0,
            "thickness_mm": 0.55,
            "width_mm": 5.0,
            "along_mm": 8.0,
            "length_mm": 7.5 * math.cos(math.radians(10)) / math.cos(math.radians(5)),
        },
    ]
    if kind == "braced":
        legs = [leg | {"kind": kind, "thickness_mm": 1.0} for leg in legs]
    if mirrored:
        places = ("tilt_deg", "along_mm")
        legs = [leg | {key: -leg[key] for key in places} for leg in legs[::-1]]
    return Design.model_validate({"legs": legs})


UNLIKE = Contact(0.5, 0.1, 0), Contact(0.8, 0.6, 0)


def unlike_hinged(mirrored=False):
    design = unlike_design(mirrored)
    return hinged.walker_of(design, masses(design))


def unlike_relaxed(mirrored=False, kind="flexible"):
    design = unlike_design(mirrored, kind)
    return relaxed.walker_of(design, masses(design))
