"""Members of a family: one forecast and one bar for all whose speed is not known without runs."""

import pytest

from walkergen.core.scene import Scene
from walkergen.core.walker import solids
from walkergen.core.walker.design import Design
from walkergen.points import members, short_simulation


@pytest.fixture
def simulated(monkeypatch):
    """Numbers of short simulations that were made, without their runs."""
    made = []

    def simulate(walker, case, progress):
        for done in range(5):
            progress("a stage", done, 4)
        made.append(walker)
        bounds = dict.fromkeys(("low", "high", "low_95", "low_68", "high_68", "high_95"), 20.0)
        return {"by": "runs", "nominal": 20.0, "falls": 0.0, "left_out": None, "mean": 20.0, "sd": 1.0, **bounds}

    monkeypatch.setattr(short_simulation, "simulate_short", simulate)
    monkeypatch.setattr(short_simulation, "load_stored", lambda walker: None)
    return made


def test_a_family_without_known_speeds_has_one_forecast_and_one_bar(simulated):
    scene = Scene.model_validate({"drive": {"frequency_hz": 90.0, "gamma": 1.8}, "plate": {"noise_ratio": 0.5}})
    designs = [Design.model_validate({"legs": {"tilt_deg": 0.8 * k, "length_mm": 30.0}}) for k in range(1, 11)]
    forecasts, bar = [], []
    found = list(
        members.predict_members(
            designs,
            [solids.build(design) for design in designs],
            scene,
            "coulomb",
            progress=lambda *step: bar.append(step),
            expect=forecasts.append,
        )
    )
    assert len(simulated) == len(found) == 10  # more than the eight that were once simulated
    assert len(forecasts) == 1
    assert {title for title, _, _ in bar} == {"speeds of 10 walkers"}
    shares = [done / total for _, done, total in bar]
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    assert forecasts[0]().seconds > 0.0
