"""Twenty meshes as STL files: round, tall, hollow, in pieces, open, inside out, in inches."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import trimesh


def _scale_mesh(mesh: "trimesh.Trimesh", *size: float) -> "trimesh.Trimesh":
    mesh.apply_transform(np.diag([*size, 1.0]))
    return mesh


def _move_mesh(mesh: "trimesh.Trimesh", *place: float) -> "trimesh.Trimesh":
    mesh.apply_translation(place)
    return mesh


def _invert_mesh(mesh: "trimesh.Trimesh") -> "trimesh.Trimesh":
    mesh.invert()
    return mesh


def _remove_lid(mesh: "trimesh.Trimesh", above: float) -> "trimesh.Trimesh":
    """Mesh without the triangles of its upper lid."""
    mesh.update_faces((mesh.triangles[:, :, 2] < above).any(axis=1))
    return mesh


def mesh_files() -> dict[str, bytes]:
    """Files of meshes by their names."""
    import trimesh
    from trimesh.creation import box, capsule, cone, cylinder, icosphere, torus

    def ball() -> "trimesh.Trimesh":
        return icosphere(subdivisions=3)

    def together(*parts: "trimesh.Trimesh") -> "trimesh.Trimesh":
        return trimesh.util.concatenate(list(parts))

    wavy = _scale_mesh(ball(), 13.0, 7.0, 6.0)
    wavy.vertices *= 1.0 + 0.06 * np.sin(0.9 * wavy.vertices[:, :1])
    lying = cylinder(5.0, 28.0)
    lying.apply_transform(trimesh.transformations.rotation_matrix(0.5 * np.pi, (0.0, 1.0, 0.0)))
    duck = (_scale_mesh(ball(), 13.0, 8.0, 6.0), _move_mesh(_scale_mesh(ball(), 5.0, 5.0, 5.0), 8.0, 0.0, 8.0))
    meshes = {
        "egg": _scale_mesh(ball(), 12.0, 6.0, 5.0),
        "ball-20": _scale_mesh(ball(), 10.0, 10.0, 10.0),
        "ball-4": _scale_mesh(ball(), 2.0, 2.0, 2.0),
        "brick": box((28.0, 12.0, 6.0)),
        "coin": cylinder(12.0, 3.0, sections=96),
        "log": lying,
        "pill": _move_mesh(capsule(14.0, 5.0), 0.0, 0.0, -7.0).apply_transform(
            trimesh.transformations.rotation_matrix(0.5 * np.pi, (0.0, 1.0, 0.0))
        ),
        "cone": cone(11.0, 16.0, sections=64),
        "ring": torus(11.0, 4.0),
        "saddle": wavy,
        "pyramid": cone(13.0, 10.0, sections=4),
        "step": together(box((14.0, 12.0, 4.0)), _move_mesh(box((16.0, 12.0, 4.0)), 13.0, 0.0, 1.5)),
        "duck": together(*duck),
        "hollow-box": together(box((26.0, 16.0, 10.0)), _invert_mesh(box((23.0, 13.0, 7.0)))),
        "tower": box((8.0, 8.0, 45.0)),
        "two-blocks": together(box((14.0, 10.0, 6.0)), _move_mesh(box((8.0, 10.0, 6.0)), 16.0, 0.0, 0.0)),
        "open-cup": _remove_lid(cylinder(10.0, 9.0, sections=64), 4.4),
        "inside-out": _invert_mesh(box((24.0, 12.0, 5.0))),
        "block-in-inches": box((1.0, 0.5, 0.25)),
        "crumbs": together(
            box((26.0, 12.0, 5.0)), *(_move_mesh(box((0.5, 0.5, 0.5)), x, 9.0, 0.0) for x in (-5.0, 5.0))
        ),
    }
    return {f"{name}.stl": bytes(mesh.export(file_type="stl")) for name, mesh in meshes.items()}
