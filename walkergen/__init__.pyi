from walkergen.api.analysing import analyse
from walkergen.api.crowding import crowd
from walkergen.api.loading import load, templates
from walkergen.api.making import export, family
from walkergen.api.measuring import bench, calibrate, fit, weigh
from walkergen.api.predicting import predict
from walkergen.api.simulating import simulate
from walkergen.api.sweeping import sweep
from walkergen.api.tracking import track
from walkergen.errors import WalkergenError
from walkergen.printing.printers import Printer
from walkergen.scene import Scene
from walkergen.walker.design import Design

__version__: str

__all__ = [
    "Design",
    "Printer",
    "Scene",
    "WalkergenError",
    "__version__",
    "analyse",
    "bench",
    "calibrate",
    "crowd",
    "export",
    "family",
    "fit",
    "load",
    "predict",
    "simulate",
    "sweep",
    "templates",
    "track",
    "weigh",
]
