"""Films of two known walkers through the writers of programs of Python; README.md says which and how.

    python tests/data/tracks/write.py

Run it where these programs are installed: sleap-io, movement and trackpy wholly; deeplabcut and idtrackerai
without what they rest on (pip install --no-deps), for their networks are not needed to write tracks.
"""

import ast
import importlib.util
import json
import shutil
import sys
import tempfile
import types
from importlib.metadata import distribution, version
from pathlib import Path

import numpy as np
import pandas as pd

HERE = Path(__file__).parent
FPS = 25.0
FRAMES = np.arange(12)
WALKERS = (
    np.stack([100.0 + 3.25 * FRAMES, 80.0 + 1.5 * FRAMES], axis=1),
    np.stack([300.0 - 2.0 * FRAMES, 40.0 + 0.5 * FRAMES**2], axis=1),
)
"""Places of two walkers, pixels; the second is not seen in frames 4 and 5."""
UNSEEN = [4, 5]
PARTS = ("head", "body", "tail")


def places():
    """Places of the walkers, shape (frames, walkers, 2)."""
    found = np.stack(WALKERS, axis=1)
    found[UNSEEN, 1] = np.nan
    return found


def poses():
    """Places of parts, shape (frames, walkers, parts, 2); all walkers head along x."""
    return places()[:, :, None] + np.array([[8.0, 0.0], [0.0, 0.0], [-8.0, 0.0]])


def sleap():
    """SLEAP's analysis table and HDF5, which SLEAP 1.6 has sleap-io write."""
    import sleap_io as sio

    skeleton = sio.Skeleton([sio.Node(part) for part in PARTS], name="walker")
    video = sio.Video(filename="film.mp4", open_backend=False)
    tracks = [sio.Track("walker_0"), sio.Track("walker_1")]
    frames = []
    for frame, bodies in enumerate(poses()):
        seen = [
            sio.PredictedInstance.from_numpy(
                body, skeleton=skeleton, point_scores=np.full(3, 0.9), score=0.9, track=track, tracking_score=0.9
            )
            for body, track in zip(bodies, tracks, strict=True)
            if np.isfinite(body).all()
        ]
        frames.append(sio.LabeledFrame(video=video, frame_idx=frame, instances=seen))
    labels = sio.Labels(frames, videos=[video], skeletons=[skeleton], tracks=tracks)
    sio.save_csv(labels, str(HERE / "sleap.csv"), format="sleap", video=video, include_empty=True)
    sio.save_analysis_h5(labels, str(HERE / "sleap.analysis.h5"))
    return f"sleap-io {version('sleap-io')}"


def movement():
    """movement's data set as NetCDF 4 and 3."""
    from movement.io import load_poses

    data = load_poses.from_numpy(
        position_array=poses().transpose(0, 3, 2, 1),
        confidence_array=np.full((len(FRAMES), len(PARTS), 2), 0.9),
        individual_names=["ann", "bob"],
        keypoint_names=list(PARTS),
        fps=FPS,
        source_software="SLEAP",
    )
    data.to_netcdf(HERE / "movement.nc")
    data.to_netcdf(HERE / "movement3.nc", engine="scipy")
    return f"movement {version('movement')}"


def deeplabcut():
    """DeepLabCut's tables of one and of several individuals, by its own function."""
    name = "deeplabcut/pose_estimation_pytorch/apis/videos.py"
    path = Path(distribution("deeplabcut").locate_file(name))
    tree = ast.parse(path.read_text(encoding="utf-8"))
    (own,) = (part for part in tree.body if getattr(part, "name", "") == "create_df_from_prediction")
    names = {"np": np, "pd": pd, "Path": Path}
    exec(compile(ast.Module([own], []), str(path), "exec"), names)
    likely = np.where(np.isfinite(poses()[..., :1]), 0.95, np.nan)
    found = np.concatenate([poses(), likely], axis=-1)
    corners = np.array([[[5.0, 6.0, 0.99], [700.0, 6.0, 0.99]]])
    for many, file in ((False, "deeplabcut_one"), (True, "deeplabcut_many")):
        people = ["ann", "bob"] if many else ["animal"]
        predicted = [
            {"bodyparts": row[: len(people)]} | ({"unique_bodyparts": corners} if many else {}) for row in found
        ]
        parts = {"bodyparts": list(PARTS), "unique_bodyparts": ["left", "right"], "individuals": people}
        with tempfile.TemporaryDirectory() as folder:
            names["create_df_from_prediction"](predicted, "DLC_film", many, {"metadata": parts}, folder, file, True)
            shutil.copy(Path(folder) / f"{file}.csv", HERE)
    return f"DeepLabCut {version('deeplabcut')}"


def idtracker():
    """Write idtracker.ai's tables and HDF5 with its own module; stubs replace a few of its package's names."""
    path = Path(distribution("idtrackerai").locate_file("idtrackerai/utils/trajectories_io.py"))
    package = types.ModuleType("utils")
    package.__path__ = []
    package.IdtrackeraiError, package.json_default = RuntimeError, str
    package.create_dir = lambda folder, remove_existing: folder.mkdir(exist_ok=True)
    package.resolve_path, package.wrap_entrypoint = Path, lambda function: function
    sys.modules["utils"] = package
    spec = importlib.util.spec_from_file_location("utils.trajectories_io", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    areas = {"mean": np.array([100.0, 101.0]), "median": np.array([100.0, 101.0]), "std": np.ones(2)}
    known = {"frames_per_second": FPS, "length_unit": None, "version": version("idtrackerai")}
    for count, name in ((2, "idtracker"), (1, "idtracker_one")):
        own = {
            "trajectories": places()[:, :count],
            "id_probabilities": np.full((len(FRAMES), count, 1), 0.99),
            "areas": {key: values[:count] for key, values in areas.items()},
            "setup_points": {},
            "identities_groups": {},
        }
        with tempfile.TemporaryDirectory() as folder:
            module.save_trajectories(Path(folder), known | own, ["csv", "csv_tidy", "h5"])
            shutil.copy(Path(folder) / "trajectories_csv/trajectories.csv", HERE / f"{name}.csv")
            if count == 2:
                shutil.copy(Path(folder) / "trajectories_tidy.csv", HERE / "idtracker_tidy.csv")
                shutil.copy(Path(folder) / "trajectories.h5", HERE / "idtracker.h5")
    return f"idtracker.ai {version('idtrackerai')}"


def trackpy():
    """trackpy's table, as linked and saved by pandas."""
    import trackpy as tp

    tp.quiet()
    rows = [
        {
            "y": y,
            "x": x,
            "mass": 1e4,
            "size": 3.0,
            "ecc": 0.1,
            "signal": 9.0,
            "raw_mass": 1e4,
            "ep": 0.01,
            "frame": frame,
        }
        for frame, bodies in enumerate(places())
        for x, y in bodies
        if np.isfinite(x)
    ]
    tp.link(pd.DataFrame(rows), 20, memory=3).to_csv(HERE / "trackpy.csv")
    return f"trackpy {tp.__version__}"


if __name__ == "__main__":
    print(json.dumps([write() for write in (sleap, movement, deeplabcut, idtracker, trackpy)], indent=1))
