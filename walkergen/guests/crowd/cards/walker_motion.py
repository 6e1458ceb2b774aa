"""Numbers of a card, from simulated runs of a walker alone or from tracks of films."""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from walkergen.analysis import alignment, motion, track_files, track_warnings, tracks
from walkergen.analysis.estimates import ALIGNMENT_NAMES
from walkergen.analysis.motion import Motion
from walkergen.analysis.track_files import Units
from walkergen.analysis.tracks import Tracks
from walkergen.core import (
    ENDED_WELL,
    GRAVITY,
    Array,
    Design,
    InputError,
    MassProperties,
    Progress,
    Quantity,
    Scene,
    format_number,
    jackknife_error,
)
from walkergen.core.simulation import ensemble
from walkergen.core.simulation.effects import sway
from walkergen.core.walker import mass as masses
from walkergen.guests.crowd.cards import delay, relaxation
from walkergen.guests.crowd.cards.delay import Delay
from walkergen.guests.crowd.cards.relaxation import Relaxation
from walkergen.points import trajectory, walkers
from walkergen.points.experiments import Walker

DEFAULT_SCENE = "plane-90hz"
"""Scene of a card by default: a walker alone has to have room to turn."""

SLOPE_DEG = 1.0
"""Slope that pushes a walker aside, a sixtieth of its weight: about a fifth of the paper's propulsion."""

SLOPE_SETTINGS = {"plate.slope_deg": SLOPE_DEG, "run.heading_deg": "uniform"}
"""Settings of a scene with a slope that pushes walkers, whose initial headings have any direction."""

MIN_INTERVAL_PERIODS = 0.75
"""Frame interval over the drive's period, below which frames are left out because they would show the bouncing."""


class Measured(NamedTuple):
    """Motion of walkers alone, sampled once in a period of the drive."""

    motion: Motion
    velocity: Relaxation
    """Relaxation of the velocity along the heading."""
    sideways: Quantity
    """Relaxation time of the velocity across the heading, s; refused for films, which have no pushes."""
    translation: Quantity
    """Translational diffusion of each axis, mm^2/s."""
    turning: Relaxation
    aligning: Quantity
    """Self-alignment, 1/mm; refused for films, which have no pushes."""
    delay: Delay
    interval: float
    """Time between samples, s."""
    runs: int
    """Number of runs, or of filmed walkers."""
    notes: tuple[str, ...]
    """Method of measurement, as text."""


def simulate_walker(scene: Scene, design: Design, mass: MassProperties, progress: Progress) -> Measured:
    """Measure the motion of a walker in simulated runs, level and on a slope.

    Each run is another print if the scene varies prints. Raises InputError if the walker cannot turn in the scene, if
    the plate sways, or if no run ends well.
    """
    sway.check_still_plate(scene, "a card needs a plate that moves up and down equally everywhere")
    if scene.arena.kind != "plane":
        raise InputError(
            f"scene.arena.kind = {scene.arena.kind!r}: a card needs a walker that can turn. "
            f"Use ‹scene=›{DEFAULT_SCENE}, or ‹set› scene.arena.kind=plane."
        )
    level, ended = _simulate_tracks(scene, design, mass, progress)
    note = (
        f"{len(level.tracks)} runs of {scene.run.seconds:g} s, sampled once in a period of the drive "
        f"({format_number(1e3 * level.interval)} ms), which leaves out the bouncing: {ended}"
    )
    sloping, _ = _simulate_tracks(scene.variant(**SLOPE_SETTINGS), design, mass, progress)
    groups = [[track] for track in sloping.tracks]
    return measure_tracks(level, exact=True, notes=(note,))._replace(
        sideways=sideways_relaxation(sloping, GRAVITY * math.sin(math.radians(SLOPE_DEG))),
        aligning=alignment.self_alignment(groups, sloping.interval, descent=0.0)[ALIGNMENT_NAMES[0]],
    )


def _simulate_tracks(scene: Scene, design: Design, mass: MassProperties, progress: Progress) -> tuple[Tracks, str]:
    """Return tracks of the centre of mass in simulated runs that ended well, and a text on how all runs ended."""
    experiment = Walker(scene, design, mass)
    interval = 1.0 / experiment.equivalent_drive.frequency
    trajectory.check_sample_count(scene, interval, scene.run.runs)
    results = walkers.simulate(experiment._replace(sample_interval=interval), progress)
    if results.partial:
        raise KeyboardInterrupt
    good = [result for result in results.results if result.outcome in ENDED_WELL]
    ended = ensemble.format_outcomes(results.summary.outcomes)
    if not good:
        raise InputError(f"no run ended well ({ended}). Use another scene, or other feet.")
    shift = centre_of_mass(mass)
    places = [shift_poses(trajectory.sample_rows(result)[:, 1:4], shift) for result in good]  # x, y, heading
    return tracks.from_positions(places, interval, lane=False), ended


def sideways_relaxation(sloping: Tracks, acceleration: float) -> Quantity:
    """Estimate the time (s) after which a velocity across the heading has forgotten a push.

    `sloping`: tracks of walkers that a slope pushes toward +x by `acceleration` (mm/s^2), at any heading. Fluctuations
    would give another time: pushes that turn a walker move it too.
    """
    rows = []
    for track in sloping.tracks:
        assert track.heading is not None
        turned = np.diff(track.heading)
        heading = track.heading[:-1] + 0.5 * turned
        v = np.diff(track.position, axis=0) / sloping.interval
        left, push = v[:, 1] * np.cos(heading) - v[:, 0] * np.sin(heading), -acceleration * np.sin(heading)
        rows.append([float(push @ left), float(push @ push), float(push.sum()), float(left.sum()), len(left)])
    sums = np.array(rows)
    whole = sums.sum(axis=0)
    # Slope of a line fitted to `left` by `push`: of all tracks, then without each in turn
    times = np.array([(a - c * d / n) / (b - c * c / n) for a, b, c, d, n in (whole, *(whole - sums))])
    se = float(jackknife_error(times[1:, None])[0])
    if not times[0] > 3.0 * se:
        return Quantity("sideways_relaxation", "s", None, refused="headings turn too little. Use longer runs")
    return Quantity("sideways_relaxation", "s", float(times[0]), se, len(rows) - 1.0)


def measure_film(path: Path, units: Units, scene: Scene) -> Measured:
    """Measure the motion from tracks in a file. Raises InputError for tracks without headings.

    If a period of the scene's drive has many frames, only one of each period is taken.
    """
    read = track_files.read_tracks(path, units)
    if read.lane or all(track.heading is None for track in read.tracks):
        raise InputError(
            f"{path}: has no headings (theta or theta_rad). A card needs them. "
            "Run `walkergen track --heading mark` to find them."
        )
    stride = 1
    if scene.drive.kind != "motor" and (period := 1.0 / scene.drive.frequency):
        stride = max(round(period / read.interval), 1) if read.interval < MIN_INTERVAL_PERIODS * period else 1
    notes = [f"{len(read.tracks)} walkers filmed", *([read.note] if read.note else [])]
    if stride > 1:
        notes.append(
            f"every {stride}th frame is used, once in a period of the drive "
            f"({scene.drive.frequency:g} Hz), which leaves out the bouncing"
        )
    return measure_tracks(_subsample(read, stride), exact=False, notes=tuple(notes))


def measure_tracks(walker_tracks: Tracks, exact: bool, notes: tuple[str, ...]) -> Measured:
    """Measure the motion in tracks with headings. `exact`: whether positions have no noise, as from a simulation.

    `notes`: sentences on the origin of the tracks. Numbers that need a sideways push have no value.
    """
    moved = motion.analyse(walker_tracks)
    both, translation = relaxation.measure_velocity(walker_tracks, exact)
    velocity = relaxation.measure_along_heading(walker_tracks, exact, both, translation)
    rotation = moved.estimates["rotational_diffusion"]
    turning = relaxation.measure_turning(walker_tracks, exact, rotation)
    reasons = () if exact else (*track_warnings.find_all(walker_tracks), *moved.doubts)
    return Measured(
        moved,
        velocity,
        Quantity("sideways_relaxation", "s", None, refused="a film has no sideways push"),
        translation,
        turning,
        moved.estimates[ALIGNMENT_NAMES[0]],
        delay.measure(walker_tracks),
        walker_tracks.interval,
        len(walker_tracks.tracks),
        (*notes, *reasons),
    )


def centre_of_mass(mass: MassProperties) -> Array:
    """Return the centre of mass relative to point O of a trajectory: forward and to the left, mm, shape (2,)."""
    return np.array([1.0, -1.0]) * _centre_and_inertia(mass)[0][[0, 2]]


def yaw_inertia(mass: MassProperties) -> float:
    """Return the moment of inertia about the vertical axis through the centre of mass, g mm^2."""
    return float(_centre_and_inertia(mass)[1][1, 1])


def _centre_and_inertia(mass: MassProperties) -> tuple[Array, Array]:
    """Return the centre of mass from O (mm), and the inertia tensor about it (g mm^2): forward, up, to the right."""
    assert mass.spatial is not None
    part_masses = np.array([mass.M, *(leg.m for leg in mass.legs)], dtype=float)
    centres = np.array([(0.0, 0.0), *(leg.anchor + leg.c_A for leg in mass.legs)])
    return masses.centre_and_inertia(mass.spatial, mass.legs, part_masses, centres)


def shift_poses(poses: Array, shift: Array) -> Array:
    """Move poses (x, y in mm, heading in rad), shape (n, 3), by `shift` (forward, to the left), mm, shape (2,)."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    x = poses[:, 0] + cos * shift[0] - sin * shift[1]
    y = poses[:, 1] + sin * shift[0] + cos * shift[1]
    return np.column_stack([x, y, poses[:, 2]])


def _subsample(walker_tracks: Tracks, stride: int) -> Tracks:
    """Return the tracks with every `stride`-th frame only."""
    thinned = tuple(
        track._replace(
            position=track.position[::stride], heading=None if track.heading is None else track.heading[::stride]
        )
        for track in walker_tracks.tracks
    )
    return walker_tracks._replace(tracks=thinned, interval=stride * walker_tracks.interval)
