"""A drawing and a mesh as people bring them, for a picture of docs/."""

from pathlib import Path

HEART = (Path(__file__).parents[1] / "examples/heart.svg").read_bytes()


def duck_stl() -> bytes:
    """Return the STL file of a body with a head, two ellipsoids that overlap."""
    import trimesh
    from trimesh.creation import icosphere

    body, head = icosphere(subdivisions=3), icosphere(subdivisions=3)
    body.apply_scale((13.0, 8.0, 6.0))
    head.apply_scale(5.0)
    head.apply_translation((8.0, 0.0, 8.0))
    return bytes(trimesh.util.concatenate([body, head]).export(file_type="stl"))
