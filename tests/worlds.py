"""Worlds of planar walkers for tests of the models' own functions, without a scene."""

import math

from walkergen.jobs.selftest.scenes import masses
from walkergen.scene import GRAVITY
from walkergen.simulation import record
from walkergen.simulation.compliant import state as hinged
from walkergen.simulation.drive import Drive, velocity
from walkergen.simulation.effects.acting import Acting
from walkergen.simulation.effects.slope import gravity_of
from walkergen.simulation.relaxed import events
from walkergen.simulation.relaxed import state as relaxed
from walkergen.simulation.world import V_Y, Contact, World
from walkergen.walker.design import Design

OMEGA = 2.0 * math.pi * 90.0
ANY = Contact(0.5, 0.25, 0)


def shaken(gamma, frequency=90.0):
    omega = 2.0 * math.pi * frequency
    return Drive(gamma * GRAVITY / omega**2, omega, None)


SHAKEN = shaken(1.8)


def world_of(walker, drive=SHAKEN, contact=ANY, options=None, slope=None, air=None):
    return World(walker, drive, contact, Acting(gravity_of(slope), air), options)


def hinged_walker(tilt, kind="flexible", **options):
    design = Design().variant(tilt_deg=float(tilt), kind=kind)
    return hinged.walker_of(design, masses(design), **options)


def hinged_state(walker, clearance, pitch=0.0, phase=0.0, drive=SHAKEN):
    """At rest in the laboratory, the lower foot `clearance` mm over the plate."""
    return hinged.start(world_of(walker, drive), clearance, pitch, phase)


def relaxed_walker(tilt=0.0, flexible=False):
    """A box on two thin legs: relaxed ones, or braced ones without mass."""
    design = Design().variant(tilt_deg=tilt, kind="flexible" if flexible else "braced")
    return relaxed.walker_of(design, masses(design))


def level_state(walker, drive, phase=0.0, gap=0.0):
    """Level, both feet `gap` (mm) over the plate and moving with it; the drive's phase in rad."""
    pitch = relaxed.level_pitch(walker)
    state = relaxed.start(world_of(walker, drive), gap, pitch, phase)
    state[V_Y] = velocity(drive, phase)
    return state


def relaxed_world(walker, drive, contact, slope=None):
    options = relaxed.options_for(walker, drive, GRAVITY)
    return world_of(walker, drive, contact, options, slope)


def go(walker, drive, contact, state, duration, slope=None, tally=None):
    """Advance a relaxed walker from event to event: status and tally."""
    tally = record.new(len(state)) if tally is None else tally
    world = relaxed_world(walker, drive, contact, slope)
    return events.advance(world, state, duration, tally), tally
