"""The walker in space without twist, as a model of MuJoCo: a free body and two legs on hinges.

Sites are the corners of the feet, in the order of `space_rival`. Lengths in mm, masses in g.
"""


def _numbers(*values):
    return " ".join(repr(float(value)) for value in values)


def _inertia(tensor):
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return _numbers(*(tensor[i, j] for i, j in pairs))


def _leg(name, anchor, design, mass):
    half, foot = 0.5 * design.body.depth_mm, mass.c_A + mass.c_T
    corners = "".join(f'<site pos="{_numbers(*foot, side)}"/>' for side in (-half, half))
    return f"""
      <body name="{name}" pos="{_numbers(*anchor, 0.0)}">
        <joint type="hinge" axis="0 0 1"/>
        <inertial pos="{_numbers(*mass.c_A, 0.0)}" mass="{_numbers(mass.m)}"
          fullinertia="{_inertia(mass.spatial.leg)}"/>
        {corners}
      </body>"""


def mujoco_walker(design, mass):
    """MJCF of a flexible walker at O, relaxed and level, without gravity or contacts."""
    legs = _leg("back", mass.a, design, mass) + _leg("front", mass.b, design, mass)
    return f"""
<mujoco>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="body">
      <freejoint/>
      <inertial pos="{_numbers(0.0, 0.0, mass.spatial.z)}" mass="{_numbers(mass.M)}"
        fullinertia="{_inertia(mass.spatial.body)}"/>{legs}
    </body>
  </worldbody>
</mujoco>
"""
