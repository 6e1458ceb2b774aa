"""Models for MuJoCo (MJCF) of walkers, with the mass properties, hinges, feet and plate of walkergen's simulation.

Units are those of walkergen: mm, g, s. Frame: x along the run, y to the left, z up. Three things differ, and the file
lists them: legs do not twist, friction has a damper instead of a spring, and tips are linear springs.

A Hertzian tip, F = K d^1.5, is replaced by the linear spring with the same contact time. A mass m that lands at a
speed v stays for I d/v, d its greatest depth, with I = 2 sqrt(pi) Gamma(7/5) / Gamma(9/10) = 2.943. On a linear spring
it stays for pi sqrt(m/k). With K d^2.5 = 1.25 m v^2 both are equal for k = pi^2 / (1.25 I^2) K sqrt(d), which is
k = 1.20 (E*^4 R^2 m v^2)^(1/5).
"""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from walkergen.core.errors import InputError
from walkergen.core.numerics import Array
from walkergen.core.printing.export import stl_bytes
from walkergen.core.scene import GRAVITY, Drive, Scene, forced_effect_line
from walkergen.core.shapes.mesh import Mesh
from walkergen.core.simulation.effects import feet, legs, turning, walls
from walkergen.core.simulation.plan import Plan, prepare
from walkergen.core.simulation.space.state import Walker
from walkergen.core.simulation.space.walker import mobility
from walkergen.core.theory.hertz import landing_depth
from walkergen.core.walker import names, solids
from walkergen.core.walker.design import Design
from walkergen.core.walker.mass import MassProperties, to_centre_frame

TO_MUJOCO = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Rotation from walkergen's frame (y up, z across) to that of MuJoCo (z up)."""

SPHERE_RADIUS_MM = 1e-3
"""Radius (mm) of the spheres that represent corners. The corners are their lowest points."""

IMPEDANCE = 1e-4
"""Smallest impedance of MuJoCo. With it, contacts are springs and dampers in physical units, to this share of mass.
"""

IMPRATIO = 100.0
"""Impedance ratio of friction to the normal direction. At 1 sliding would press the feet down."""

STEP_RATIO = 4.0
"""Step of walkergen over that of MuJoCo, whose contacts are explicit. docs/mujoco.md states the accuracy."""

PLATE_MASS_G = 1e9
"""Mass of the plate, g: walkers do not move it."""


HERTZ_TIME = 2.0 * math.sqrt(math.pi) * math.gamma(1.4) / math.gamma(0.9)
"""Contact time of a landing on a Hertzian tip without damper, times speed over greatest depth."""

SUPPORTED_EFFECTS = {legs.COMPLIANCE, feet.NAME, turning.NAME, walls.NAME, walls.LID}
"""Effects of a scene with a switch in walkergen that an MJCF file can represent."""


def files(design: Design, scene: Scene) -> Iterator[tuple[str, bytes]]:
    """Yield the names and bytes of a walker's MJCF and of the STL files that it shows.

    Raises InputError for a scene with effects that the model leaves out.
    """
    name, built = names.part_name(design), solids.build(design)
    mass = solids.weigh(design, built)
    plan = _prepare_plan(design, scene, mass)
    walker = plan.world.walker
    yield f"{name}.xml", _format_model(name, plan).encode()
    for part, mesh in _meshes(design, mass, walker, built):
        yield f"{name}_{part}.stl", stl_bytes(mesh, f"{name} {part}")


def linear_springs(plan: Plan) -> Array:
    """Return the stiffness (g/s^2) of each point of contact in the file, shape (k,).

    The spring of the leg is in series with the linear spring of the tip. The latter is that of a landing with an equal
    share of the mass, at LANDING_SPEED_RATIO times the plate's peak speed. If the plate hardly moves, it is that of
    the weight.
    """
    walker = plan.world.walker
    share = walker.mass / np.count_nonzero(walker.wall_distance == 0.0)  # at 0 are the points that may touch the plate
    speed = feet.LANDING_SPEED_RATIO * plan.equivalent_drive.peak_speed
    depths = np.array([landing_depth(tip, share, speed, GRAVITY * share) for tip in walker.tip])
    depths[np.isinf(walker.tip)] = 1.0  # any: rigid tips are infinitely stiff
    tips = math.pi**2 / (1.25 * HERTZ_TIME**2) * walker.tip * np.sqrt(depths)
    return np.asarray(1.0 / (1.0 / walker.spring + 1.0 / tips))


def _prepare_plan(design: Design, scene: Scene, mass: MassProperties) -> Plan:
    """Prepare the 3D simulation of a walker without leg twist. Raises InputError for effects that MJCF lacks."""
    effects = scene.effects.force("leg_twist", state=False)
    plan = prepare(scene.model_copy(update={"effects": effects}), design, mass)
    resolved = plan.resolved
    if not resolved.is_on(turning.NAME):
        raise InputError(
            f"{forced_effect_line(turning.SWITCH, False)}: MJCF supports only walkers that are free to turn. Remove it."
        )
    for effect in resolved.effects:
        if effect.on and effect.switch and effect.name not in SUPPORTED_EFFECTS:
            away = f"‹set› 'scene.{forced_effect_line(effect.switch, on=False)}'"
            raise InputError(f"{effect.name} ({effect.reason}): MJCF does not support it. To leave it out, add {away}")
    return plan


def _meshes(design: Design, mass: MassProperties, walker: Walker, built: solids.Solids) -> Iterator[tuple[str, Mesh]]:
    """Yield the name and the mesh of each part: free legs relative to their anchors, others to the centre of mass."""
    O, half = walker.centre, 0.5 * design.size.depth  # noqa: E741  (the paper's name)
    middle = np.array([*to_centre_frame(design.limbs, mass, np.zeros(2)), -half]) + O
    yield "body", _to_mujoco_frame(built._replace(walker=built.body).walker_with_cap, middle)
    for name, limb, leg, mesh in zip(names.leg_names(design), design.limbs, mass.legs, built.legs, strict=True):
        anchor = np.array([*leg.anchor, limb.across]) + O
        anchor = np.zeros(3) if leg.m > 0.0 else anchor
        yield name, _to_mujoco_frame(mesh, anchor - (0.0, 0.0, 0.5 * limb.width))


def _to_mujoco_frame(mesh: Mesh, offset: Array) -> Mesh:
    """Transform a mesh, shifted by an offset, to MuJoCo's frame."""
    return mesh._replace(vertices=(mesh.vertices + offset) @ TO_MUJOCO.T)


def _format_model(name: str, plan: Plan) -> str:
    """Return the MJCF of a walker that starts one amplitude above the plate, with the plate at its highest."""
    scene, design, mass, walker = plan.scene, plan.case.design, plan.case.mass, plan.world.walker
    drive, leg_names = scene.drive, names.leg_names(design)
    period = 2.0 * math.pi / drive.omega
    timestep = period / math.ceil(STEP_RATIO * period / plan.world.options.step)
    height = 2.0 * drive.amplitude - float((walker.root + _contact_offsets(walker))[:, 1].min())
    free = [k for k, leg in enumerate(mass.legs) if float(leg.m) > 0.0]
    leg_bodies = "".join(_leg_body(number, leg_names[k], mass, walker, k) for number, k in enumerate(free))
    body_parts = ["body", *(leg_names[k] for k in range(len(leg_names)) if k not in free)]
    assets = "".join(
        f'''
    <mesh name="{part}" file="{name}_{part}.stl" inertia="shell"/>'''
        for part in ("body", *leg_names)
    )
    assert mass.spatial is not None
    return f"""<!-- {name} by walkergen: units mm, g, s (forces in uN, energies in nJ); x along the
  run, y to the left, z up. Masses and inertias are walkergen's, not the meshes', which are only
  seen. Left out: the twist of the legs, and the spring of friction, which a damper replaces.
  Feet have linear springs. walkergen's tips are Hertzian, stiffer the deeper they are pressed. A
  linear spring here has the same contact time for a quarter of the mass at twice the plate's peak
  speed (four corners; in general an equal share), in series with the leg. The damper gives the
  scene's restitution. With small gamma, below about 1.4, walkers run slower than on Hertzian tips.
  The plate, heavy enough not to feel the walker, swings on a spring: {drive.frequency:g} Hz,
  {drive.peak_gamma:g} g, amplitude {1e3 * drive.amplitude:.6g} um, at its highest at time 0.
  solref of the feet: stiffness and damping of a corner in g/s^2 and g/s, times MuJoCo's inverse
  mass of its body (1/g): with the impedance near 0 contacts have these, whatever they carry. -->
<mujoco model="{name}">
  <compiler angle="radian" inertiafromgeom="false" autolimits="true"/>
  <option timestep="{timestep!r}" gravity="0 0 {-GRAVITY!r}" cone="elliptic" impratio="{IMPRATIO:g}"
    integrator="implicitfast" solver="Newton" tolerance="1e-16" iterations="50"/>
  <statistic extent="{3.0 * design.size.length!r}" center="0 0 0"/>
  <asset>{assets}
  </asset>
  <worldbody>
    <light pos="0 -300 300" dir="0 1 -1"/>{_plate_body(scene.drive, walker, height)}
    <body name="walker" pos="0 0 {height!r}">
      <freejoint name="walker"/>
      {_inertial(walker.centre, float(mass.M), mass.spatial.body)}{_visual_geoms(body_parts)}
      {_corner_geoms(walker, -1)}{leg_bodies}
    </body>
  </worldbody>
  <contact>{_contact_pairs(mass, walker, free, linear_springs(plan))}
  </contact>
</mujoco>
"""


def _leg_body(free_index: int, name: str, mass: MassProperties, walker: Walker, index: int) -> str:
    """Return the MJCF of a free leg on its hinge, with the corners of its foot.

    `free_index`: index among the free legs. `index`: index among all legs.
    """
    leg, row = mass.legs[index], int(np.flatnonzero(walker.leg == free_index)[0])
    assert leg.tensor is not None
    centre = np.array([*leg.c_A, leg.across - walker.centre[2] - walker.root[row, 2]])
    return f"""
      <body name="{name}" pos="{_format_point(walker.root[row])}">
        <joint name="{name}" type="hinge" axis="{_format_point(np.array([0.0, 0.0, 1.0]))}"
          stiffness="{float(walker.stiffness[free_index])!r}"
          damping="{float(walker.damping[free_index])!r}"/>
        {_inertial(centre, float(leg.m), leg.tensor)}{_visual_geoms([name])}
        {_corner_geoms(walker, free_index)}
      </body>"""


def _contact_offsets(walker: Walker) -> Array:
    """Return the vector from its anchor to each point of contact, shape (k, 3), mm."""
    return np.column_stack([walker.reach, walker.side])


def _corner_geoms(walker: Walker, leg: int) -> str:
    """Return the spheres, as MJCF, of the points of contact on a free leg (by its index), or on the body (-1)."""
    spheres = []
    for k in np.flatnonzero(walker.leg == leg):
        on_body = walker.root[k] if leg < 0 else 0.0
        inward = [0.0, 0.0, -math.copysign(SPHERE_RADIUS_MM, walker.root[k, 2])]
        if (distance := walker.wall_distance[k]) <= 0.0:
            inward = [0.0, math.copysign(SPHERE_RADIUS_MM, distance), 0.0]
        spheres.append(
            f'<geom name="corner{k}" type="sphere" size="{SPHERE_RADIUS_MM}" mass="0" contype="0" '
            f'conaffinity="0" pos="{_format_point(on_body + _contact_offsets(walker)[k] + inward)}"/>'
        )
    return "\n        ".join(spheres)


def _plate_body(drive: Drive, walker: Walker, height: float) -> str:
    """Return the MJCF of the plate on its spring, with a lid or with walls twice as high as the body's middle."""
    wall_side, lid, bodies = float(walker.wall_distance.max()), -float(walker.wall_distance.min()), ""
    for side in (-1, 1) if wall_side > 0.0 else ():
        bodies += f"""
      <geom name="wall{side:+d}" type="box" size="2000 5 {height!r}" rgba=".6 .6 .6 .2"
        pos="0 {side * (wall_side + 5.0)!r} {height!r}" contype="0" conaffinity="0"/>"""
    if lid > 0.0:
        bodies += f"""
      <geom name="lid" type="box" size="2000 2000 5" pos="0 0 {lid + 5.0!r}" rgba=".6 .6 .6 .2" contype="0"
        conaffinity="0"/>"""
    return f"""
    <body name="plate" pos="0 0 {drive.amplitude!r}" gravcomp="1">
      <joint name="plate" type="slide" axis="0 0 1" stiffness="{PLATE_MASS_G * drive.omega**2!r}"
        springref="{-drive.amplitude!r}"/>
      <inertial pos="0 0 0" mass="{PLATE_MASS_G!r}" diaginertia="{PLATE_MASS_G!r} {PLATE_MASS_G!r} {PLATE_MASS_G!r}"/>
      <geom name="plate" type="box" size="2000 2000 5" pos="0 0 -5" rgba=".6 .6 .6 1"
        contype="0" conaffinity="0"/>{bodies}
    </body>"""


def _contact_pairs(mass: MassProperties, walker: Walker, free: Sequence[int], springs: Array) -> str:
    """Return the contact pairs, as MJCF: corners with the plate, the body's points with walls or a lid.

    `free`: indices of free legs. `springs`: stiffness of the contacts, shape (k,), g/s^2.
    """
    H, inverse = mobility(walker), _inverse_masses(mass, walker, free)
    pairs = ""
    for k, friction in enumerate(walker.friction):
        scale = (1.0 - IMPEDANCE) * inverse[k]
        slip = max(H[3 * k + 1, 3 * k + 1], H[3 * k + 2, 3 * k + 2])
        sideways = 2.0 * math.sqrt(walker.shear[k] * springs[k] / slip) * scale / IMPRATIO
        normal = _format_numbers(-scale * springs[k], -scale * walker.damper[k] * math.sqrt(springs[k]))
        for other in {1.0: ("wall-1", "wall+1"), 0.0: ("plate",), -1.0: ("lid",)}[np.sign(walker.wall_distance[k])]:
            pairs += f'''
    <pair geom1="{other}" geom2="corner{k}" condim="3" solref="{normal}"
      solreffriction="{_format_numbers(-1.0, -sideways)}" friction="{_format_numbers(friction, friction)} 0 0 0"
      solimp="{IMPEDANCE} {IMPEDANCE} 1 0.5 1"/>'''
    return pairs


def _inverse_masses(mass: MassProperties, walker: Walker, free: Sequence[int]) -> Array:
    """Compute the inverse mass (1/g) that MuJoCo uses for the body of each contact, shape (k,).

    It is the mean over three directions at the centre of mass of that body. `free`: indices of free legs.
    """
    root, reach, side = walker.root.copy(), 0.0 * walker.reach, 0.0 * walker.side
    for k, number in enumerate(walker.leg):
        if number < 0:
            root[k] = walker.centre
        else:
            leg = mass.legs[free[number]]
            reach[k], side[k] = leg.c_A, leg.across - walker.centre[2] - root[k, 2]
    H = mobility(walker._replace(root=root, reach=reach, side=side, wall_distance=0.0 * walker.wall_distance))
    return np.asarray(np.diag(H).reshape(-1, 3).mean(axis=1))


def _inertial(centre: Array, mass: float, tensor: Array) -> str:
    """Return the MJCF of a mass (g) with its centre (mm) and inertia tensor (g mm^2) in walkergen's frame."""
    tensor = TO_MUJOCO @ tensor @ TO_MUJOCO.T
    entries = _format_numbers(*(tensor[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))))
    return f'<inertial pos="{_format_point(centre)}" mass="{mass!r}"\n          fullinertia="{entries}"/>'


def _visual_geoms(parts: Sequence[str]) -> str:
    """Return the MJCF of meshes that are only displayed. `parts`: their names."""
    return "".join(
        f'''
        <geom type="mesh" mesh="{part}" mass="0" contype="0" conaffinity="0" group="1"/>'''
        for part in parts
    )


def _format_point(vector: Array) -> str:
    """Format a vector in walkergen's frame, shape (3,), as numbers in MuJoCo's frame."""
    return _format_numbers(*(TO_MUJOCO @ vector))


def _format_numbers(*values: float) -> str:
    return " ".join(repr(float(value) + 0.0) for value in values)
