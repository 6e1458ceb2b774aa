"""A drawing and a mesh as people bring them, for a picture of docs/."""

HEART = (
    b'<svg xmlns="http://www.w3.org/2000/svg" width="30.0mm" height="28.0mm" viewBox="0 0 30.0 28.0"><path '
    b'fill-rule="nonzero" d="M15 27C-5 12 3 0 10 2C13 3 15 6 15 6C15 6 17 3 20 2C27 0 35 12 15 27Z"/></svg>'
)


def duck_stl() -> bytes:
    """Return the STL file of a body with a head, two ellipsoids that overlap."""
    import trimesh
    from trimesh.creation import icosphere

    body, head = icosphere(subdivisions=3), icosphere(subdivisions=3)
    body.apply_scale((13.0, 8.0, 6.0))
    head.apply_scale(5.0)
    head.apply_translation((8.0, 0.0, 8.0))
    return bytes(trimesh.util.concatenate([body, head]).export(file_type="stl"))
