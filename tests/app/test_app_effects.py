"""What each effect changes, on the page: measured by `explain --measure`, as rows, picture and advice."""

import base64
import json

import pytest
from app_doors import Doors, document

PAPER = document() | {"scene": "lane-90hz"}


def test_effects_that_nobody_measured_have_no_picture(tmp_path):
    assert (
        "the effects of this walker have not been measured. Measure them first"
        in Doors(tmp_path).ask("effects_drawn", {"document": PAPER}).refused
    )


@pytest.mark.slow  # ten seconds, as people wait for
def test_effects_are_measured_and_drawn(tmp_path):
    doors = Doors(tmp_path)
    events = doors.ask("effects", {"document": PAPER}).events
    assert any("progress" in event for event in events)
    facts = json.loads(events[-1]["output"])
    assert {"plate slope", "second harmonic"} < {row["effect"] for row in facts["measured"]}
    assert facts["advice"]
    head, data = doors.ask("effects_drawn", {"document": PAPER}).json["picture"].split(",")
    assert head == "data:image/png;base64"
    assert base64.b64decode(data).startswith(b"\x89PNG")
