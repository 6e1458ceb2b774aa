from walkergen.errors import WalkergenError
from walkergen.notebook.analysing import analyse
from walkergen.notebook.loading import load, templates
from walkergen.notebook.making import export, family
from walkergen.notebook.measuring import bench, calibrate, fit, weigh
from walkergen.notebook.predicting import predict
from walkergen.notebook.simulating import simulate
from walkergen.notebook.sweeping import sweep
from walkergen.notebook.tracking import track
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
