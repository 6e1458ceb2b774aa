"""The exported walker in Drake: bodies, hinges and corners of the MJCF file. Needs the extra `rivals`.

Units are SI, as Drake's users have them. Corners have the linear springs of the file, with Drake's damper
(Hunt-Crossley) in place of a linear one: both give the scene's restitution at the landing speed. Friction is
regularised below a slip of STICTION_M_S. CENIC is Drake's integrator with error control (Kurtz et al.,
arXiv 2511.08771): its user states an accuracy, not a step.
"""

import math
from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import AddContactMaterial, HalfSpace, ProximityProperties, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    PrismaticJoint,
    PrismaticSpring,
    RevoluteJoint,
    RevoluteSpring,
    RotationalInertia,
    SpatialInertia,
)
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import DiagramBuilder

from evidence.work_precision.case import PERIODS_PER_POSE, Case, count_poses, draw_start, speed_along_heading
from walkergen.core.scene import GRAVITY
from walkergen.core.simulation.effects.feet import LANDING_SPEED_RATIO

MM, GRAM = 1e-3, 1e-3
"""A millimetre in m and a gram in kg."""

TORQUE_UNIT, SPRING_UNIT, INERTIA_UNIT = 1e-9, 1e-3, 1e-9
"""Units of mm, g and s in SI: g mm^2/s^2, g/s^2, g mm^2."""

PLATE_MASS_KG = 1e6
"""Mass of the plate on its spring: walkers do not move it."""

PLATE_STIFFNESS = 1e15
"""Stiffness of the plate, N/m. Corners are in series with it."""

STICTION_M_S = 1e-4
"""Slip below which friction grows with the slip, m/s: a thousandth of the walker's landing speed."""

CORNER_RADIUS_M = 1e-6


class DrakeWalker:
    """Diagram of the walker on its plate."""

    def __init__(self, case: Case) -> None:
        self.case, self.drive = case, case.walker.scene.drive
        root = ElementTree.fromstring(case.mjcf)
        self._bodies = {element.get("name"): element for element in root.iter("body")}
        builder = DiagramBuilder()
        self.plant, _ = AddMultibodyPlantSceneGraph(builder, 0.0)
        self.plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -MM * GRAVITY])
        self._add_plate()
        lowest = self._add_walker({pair.get("geom2") for pair in root.iter("pair") if pair.get("geom1") == "plate"})
        self.start_height = 2.0 * MM * self.drive.amplitude - lowest
        self.plant.Finalize()
        self.plant.set_stiction_tolerance(STICTION_M_S)
        self.diagram = builder.Build()

    def _add_plate(self) -> None:
        """Add the plate on its spring."""
        plant, instance = self.plant, self.plant.AddModelInstance("plate")
        inertia = SpatialInertia.SolidBoxWithMass(PLATE_MASS_KG, 1.0, 1.0, 1.0)
        plate = plant.AddRigidBody("plate", instance, inertia)
        plant.set_gravity_enabled(instance, False)
        self.slide = plant.AddJoint(PrismaticJoint("slide", plant.world_frame(), plate.body_frame(), [0.0, 0.0, 1.0]))
        plant.AddForceElement(PrismaticSpring(self.slide, 0.0, PLATE_MASS_KG * self.drive.omega**2))
        material = self._material(PLATE_STIFFNESS, 0.0)
        plant.RegisterCollisionGeometry(plate, RigidTransform(), HalfSpace(), "plate", material)

    def _add_walker(self, touching: set[str | None]) -> float:
        """Add body, legs and corners. Return the height (m) of the lowest corner over the body's origin."""
        plant, instance = self.plant, self.plant.AddModelInstance("walker_parts")
        element = self._bodies["walker"]
        self.walker = plant.AddRigidBody("walker", instance, _inertia(element))
        parts = [(self.walker, element, np.zeros(3))]
        for leg in element.findall("body"):
            joint, name, anchor = leg.find("joint"), leg.get("name"), MM * _vector(leg)
            assert joint is not None
            body = plant.AddRigidBody(name, instance, _inertia(leg))
            frame = FixedOffsetFrame(f"{name}_anchor", self.walker.body_frame(), RigidTransform(anchor))
            axis, damping = _vector(joint, "axis"), TORQUE_UNIT * _number(joint, "damping")
            hinge = RevoluteJoint(name, plant.AddFrame(frame), body.body_frame(), axis, damping=damping)
            plant.AddForceElement(RevoluteSpring(plant.AddJoint(hinge), 0.0, TORQUE_UNIT * _number(joint, "stiffness")))
            parts.append((body, leg, anchor))
        contact = self.case.walker.scene.contact
        damper = dissipation(contact.restitution, MM * LANDING_SPEED_RATIO * self.drive.peak_speed)
        lowest = math.inf
        for body, part, anchor in parts:
            for name, centre in _corners(part, touching):
                stiffness = SPRING_UNIT * float(self.case.springs[int(name.removeprefix("corner"))])
                sphere, material = Sphere(CORNER_RADIUS_M), self._material(stiffness, damper)
                plant.RegisterCollisionGeometry(body, RigidTransform(centre), sphere, name, material)
                lowest = min(lowest, float((anchor + centre)[2]) - CORNER_RADIUS_M)
        return lowest

    def _material(self, stiffness: float, damper: float) -> Any:
        friction = self.case.walker.scene.contact.friction
        properties = ProximityProperties()
        AddContactMaterial(
            dissipation=damper,
            point_stiffness=stiffness,
            friction=CoulombFriction(friction, friction),
            properties=properties,
        )
        return properties


def simulate_speed(walker: DrakeWalker, accuracy: float, seconds: float, seed: int) -> float:
    """Return the mean speed (mm/s) of one run with CENIC at an accuracy."""
    period, start, drive = walker.case.period, draw_start(seed), walker.drive
    interval, plant = PERIODS_PER_POSE * period, walker.plant
    simulator = Simulator(walker.diagram)
    config = SimulatorConfig(integration_scheme="cenic", accuracy=accuracy, max_step_size=1e-3, use_error_control=True)
    ApplySimulatorConfig(config, simulator)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    amplitude = MM * drive.amplitude
    walker.slide.set_translation(context, amplitude * math.sin(start.phase))
    walker.slide.set_translation_rate(context, amplitude * drive.omega * math.cos(start.phase))
    pose = RigidTransform(Quaternion(start.quaternion), [0.0, 0.0, walker.start_height])
    plant.SetFreeBodyPose(context, walker.walker, pose)
    simulator.Initialize()
    poses = []
    for number in range(count_poses(seconds, period) + 1):
        if number:
            simulator.AdvanceTo(number * interval)
        pose = plant.EvalBodyPoseInWorld(context, walker.walker)
        along = pose.rotation().matrix()[:2, 0]
        poses.append([*pose.translation()[:2] / MM, *along / np.linalg.norm(along)])
    return speed_along_heading(np.array(poses), interval)


def dissipation(restitution: float, speed: float) -> float:
    """Return Drake's dissipation (s/m) for which a landing at `speed` (m/s) has a restitution e.

    With force k x (1 + d v), energy gives a - ln(1 + a) = -e a - ln(1 - e a) for a = d v. Solved by bisection.
    """
    low, high = 1e-9, (1.0 - 1e-12) / restitution
    for _ in range(200):
        a = 0.5 * (low + high)
        falls_short = a - math.log1p(a) > -restitution * a - math.log1p(-restitution * a)
        low, high = (a, high) if falls_short else (low, a)
    return 0.5 * (low + high) / speed


def _corners(part: ElementTree.Element, touching: set[str | None]) -> Iterator[tuple[str, Any]]:
    """Yield the names and centres (m) of the corners of a part that touch the plate."""
    for geom in part.findall("geom"):
        name = geom.get("name")
        if name in touching and name is not None:
            yield name, MM * _vector(geom)


def _inertia(element: ElementTree.Element) -> Any:
    inertial = element.find("inertial")
    assert inertial is not None
    moments = INERTIA_UNIT * _vector(inertial, "fullinertia")
    mass, centre = GRAM * _number(inertial, "mass"), MM * _vector(inertial)
    return SpatialInertia.MakeFromCentralInertia(mass, centre, RotationalInertia(*moments))


def _vector(element: ElementTree.Element, key: str = "pos") -> Any:
    return np.array([float(word) for word in element.get(key, "").split()])


def _number(element: ElementTree.Element, key: str) -> float:
    return float(element.get(key, ""))
