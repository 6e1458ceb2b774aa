"""What makes a walker's solid sound: one closed body, outward, with its windows and no other."""

import pytest
import trimesh

from walkergen.core.walker import mass, solids


def to_trimesh(mesh):
    """Convert a mesh to trimesh's object; vertices and their order stay the same."""
    return trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)


def check(design):
    """Build a design, check its walker, and return what was built."""
    built = solids.build(design)
    mesh = to_trimesh(built.walker)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.body_count == 1
    assert mesh.volume > 0
    genus = 1 - mesh.euler_number // 2
    assert genus == sum(solids.has_window(limb) for limb in design.limbs)
    whole, body, *legs = (mass.weigh(part, 1.0).volume for part in (built.walker, built.body, *built.legs))
    # The union neither loses nor doubles anything: coordinates carry 16 digits.
    assert whole == pytest.approx(body + sum(legs), rel=1e-12)
    z = built.walker.vertices[:, 2]
    assert (z.min(), z.max()) == (0.0, design.size.depth)
    return built
