"""What a slider's step asks of the server: the walker at once, a curve of few points, the whole once it rests."""

import pytest
from app_doors import PAPER, document

from walkergen.app import answers, curves
from walkergen.app.document import Document
from walkergen.files import config


def of_page(**values):
    return Document(**document(**values))


def test_a_curve_has_few_points_while_a_slider_moves():
    rough, whole = (curves.curve(of_page(body__length_mm=27.0), rough) for rough in (True, False))
    assert len(rough["speed"]) * 5 < len(whole["speed"])
    for tilt, speed in zip(rough["tilt_deg"], rough["speed"], strict=True):
        if tilt in whole["tilt_deg"]:
            assert speed == whole["speed"][whole["tilt_deg"].index(tilt)]


def test_a_curve_does_not_depend_on_the_tilt_and_is_none_where_legs_share_none():
    assert curves.curve(of_page(legs__tilt_deg=7.0), True) == curves.curve(of_page(legs__tilt_deg=13.0), True)
    assert curves.curve(Document(**PAPER | {"walker": "unequal-legs"}), True) is None


@pytest.mark.parametrize("key", ["legs.tilt_deg", "body.length_mm", "scene.contact.friction"])
def test_a_step_reads_no_file_of_a_template_again(monkeypatch, key):
    steps = [of_page(**{key: value}) for value in {"l": (11.5, 12.5), "b": (27.5, 28.5), "s": (0.31, 0.33)}[key[0]]]
    for ask in (answers.packed, answers.outlook):
        ask(steps[0])

    def read(path):
        pytest.fail(f"{path} was read again")

    monkeypatch.setattr(config, "load", read)
    for ask in (answers.packed, answers.outlook):
        ask(steps[1])
