"""Content of the reference: the public API, a page for each of its parts."""

import griffe

import walkergen
from walkergen.command_table import COMMANDS

FIRST = ["load", "predict", "simulate", "family"]
CALLS = [*FIRST, *(name for name in COMMANDS if name in walkergen.__all__ and name not in FIRST), "WalkergenError"]
"""What people call after `import walkergen as wg`."""

REFERENCE = {
    "python": (
        "# From Python\n\n`import walkergen as wg`, and then these. A `Walker` is a `wg.Design` or the name of a "
        "template or of a file. In the same way a `Ground` is a `wg.Scene` or a name, and a `Machine` a `wg.Printer` "
        "or a name.",
        [f"walkergen.{name}" for name in CALLS],
    ),
    "results": (
        "# Results\n\nEvery function returns a `Report` with its tables. Most reports add results of their own.",
        [
            "walkergen.files.report.Report",
            "walkergen.files.report.Table",
            "walkergen.commands.predict.make.PredictReport",
            "walkergen.commands.simulate.report.SimulationReport",
            "walkergen.guests.sweep.report.SweepReport",
            "walkergen.commands.family.report.FamilyReport",
            "walkergen.commands.check.make.CheckReport",
            "walkergen.commands.check.weigh_report.WeighReport",
            "walkergen.guests.track.film.report.TrackReport",
            "walkergen.guests.track.analyse.report.AnalysisReport",
            "walkergen.guests.lab.fit.report.FitReport",
            "walkergen.guests.crowd.cards.card.Card",
        ],
    ),
    "core": (
        "# The core\n\n`from walkergen.core import Design`, and so on: from a design to a part, its masses, its "
        "predicted and its simulated speed. [Story](../story.md) shows how it works.",
        [
            "walkergen.core.walker.design.Design",
            "walkergen.core.scene.Scene",
            "walkergen.core.printing.printers.Printer",
            "walkergen.core.numerics.quantity.Quantity",
            "walkergen.core.walker.solids.build",
            "walkergen.core.walker.solids.Solids",
            "walkergen.core.walker.solids.mass_of",
            "walkergen.core.walker.mass.MassProperties",
            "walkergen.core.theory.prediction.predict",
            "walkergen.core.theory.prediction.Prediction",
            "walkergen.core.simulation.plan.prepare",
            "walkergen.core.simulation.run.simulate",
            "walkergen.core.simulation.run.RunResult",
        ],
    ),
}
"""Text and objects of each page."""


class RequestDocstrings(griffe.Extension):
    """Docstrings of the functions that are made of requests, as `help(wg.predict)` shows them."""

    def on_function(self, *, func, **_):
        """Replace the docstring of a function of the package's stub."""
        if func.parent.path == "walkergen" and func.name in CALLS:
            func.docstring = griffe.Docstring(getattr(walkergen, func.name).__doc__, parser="numpy", parent=func)
