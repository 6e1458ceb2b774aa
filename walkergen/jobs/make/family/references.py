"""References of what a run used, and no others."""

from collections.abc import Collection
from typing import Literal, NamedTuple

Subject = Literal[
    "walkers",
    "poisson",
    "newton",
    "stronge",
    "event",
    "step",
    "matplotlib",
    "manifold3d",
    "numpy",
    "numba",
    "lib3mf",
    "three.js",
]


class Reference(NamedTuple):
    """Reference to a work, and what the work was used for."""

    use: str
    text: str
    url: str


REFERENCES: dict[Subject, Reference] = {
    "walkers": Reference(
        "walkers, their theory and the experiment",
        "N. Koumakis, A. Gnoli, C. Maggi, A. Puglisi, R. Di Leonardo: Mechanism of self-propulsion "
        "in 3D-printed active granular particles. New Journal of Physics 18, 113046 (2016)",
        "https://doi.org/10.1088/1367-2630/18/11/113046",
    ),
    "poisson": Reference(
        "restitution of the normal impulse, followed through sliding and sticking",
        "E. J. Routh: The Elementary Part of a Treatise on the Dynamics of a System of Rigid "
        "Bodies, 7th edition, Macmillan (1905), on Poisson's hypothesis and impact with friction",
        "",
    ),
    "newton": Reference(
        "restitution of the normal velocity",
        "I. Newton: Philosophiae Naturalis Principia Mathematica (1687), scholium to the laws of motion",
        "",
    ),
    "stronge": Reference(
        "restitution of energy",
        "W. J. Stronge: Rigid body collisions with friction. Proceedings of the Royal Society of "
        "London A 431, 169-181 (1990)",
        "https://doi.org/10.1098/rspa.1990.0125",
    ),
    "event": Reference(
        "motion between events",
        "J. R. Dormand, P. J. Prince: A family of embedded Runge-Kutta formulae. Journal of "
        "Computational and Applied Mathematics 6, 19-26 (1980)",
        "https://doi.org/10.1016/0771-050X(80)90013-3",
    ),
    "step": Reference(
        "time stepping with contact",
        "J. J. Moreau: Numerical aspects of the sweeping process. Computer Methods in Applied "
        "Mechanics and Engineering 177, 329-349 (1999); M. Jean: The non-smooth contact dynamics "
        "method, 177, 235-257 of the same volume",
        "https://doi.org/10.1016/S0045-7825(98)00387-9",
    ),
    "numba": Reference(
        "compiled simulation",
        "S. K. Lam, A. Pitrou, S. Seibert: Numba: a LLVM-based Python JIT compiler. Proceedings of "
        "the Second Workshop on the LLVM Compiler Infrastructure in HPC, 7 (2015)",
        "https://doi.org/10.1145/2833157.2833162",
    ),
    "numpy": Reference(
        "arrays",
        "C. R. Harris et al.: Array programming with NumPy. Nature 585, 357-362 (2020)",
        "https://doi.org/10.1038/s41586-020-2649-2",
    ),
    "matplotlib": Reference(
        "pictures",
        "J. D. Hunter: Matplotlib: a 2D graphics environment. Computing in Science & Engineering 9, 90-95 (2007)",
        "https://doi.org/10.1109/MCSE.2007.55",
    ),
    "manifold3d": Reference("solids", "Manifold, geometry library", "https://github.com/elalish/manifold"),
    "lib3mf": Reference("3MF files", "lib3mf, 3MF Consortium", "https://github.com/3MFConsortium/lib3mf"),
    "three.js": Reference("this page's viewer", "three.js", "https://threejs.org"),
}
"""All works that can be cited, in the order of citing."""


def cited(
    laws: Collection[str], methods: Collection[str], files: Collection[str], played: bool = False
) -> list[Reference]:
    """List the references of a family's run, by its table's laws and methods and its files.

    `laws`: of restitution; `methods`: of simulation ("event", "step"), none when nothing was
    simulated; `files`: their names in the manifest; `played`: whether the page plays a run.
    """
    used: set[str] = {"walkers", "numpy", "manifold3d", "three.js", *laws, *methods}
    if methods or played:
        used.add("numba")
    if any(name.endswith(".png") for name in files):
        used.add("matplotlib")
    if any(name.endswith(".3mf") for name in files):
        used.add("lib3mf")
    return [reference for subject, reference in REFERENCES.items() if subject in used]
