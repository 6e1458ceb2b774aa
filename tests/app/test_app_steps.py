"""What a slider's step asks of the server: the walker at once, a curve of few points, the whole once it rests."""

import pytest
from app_doors import PAPER, Doors, document

from walkergen.app import curves, walker_answers
from walkergen.app.document import Document
from walkergen.core.files import config


def of_page(**values):
    return Document(**document(**values))


def test_a_curve_has_few_points_while_a_slider_moves():
    rough, whole = (curves.speed_curve(of_page(body__length_mm=27.0), rough) for rough in (True, False))
    assert len(rough["speed"]) * 5 < len(whole["speed"])
    for tilt, speed in zip(rough["tilt_deg"], rough["speed"], strict=True):
        if tilt in whole["tilt_deg"]:
            assert speed == whole["speed"][whole["tilt_deg"].index(tilt)]


def test_a_curve_does_not_depend_on_the_tilt_and_is_none_where_legs_share_none(tmp_path):
    assert curves.speed_curve(of_page(legs__tilt_deg=7.0), True) == curves.speed_curve(
        of_page(legs__tilt_deg=13.0), True
    )

    unlike = {"document": PAPER | {"walker": "unequal-legs"}}
    answer = Doors(tmp_path).ask("curve", unlike)
    assert (answer.status, answer.json) == (200, {"curve": None})


@pytest.mark.parametrize("key", ["legs.tilt_deg", "body.length_mm", "scene.contact.friction"])
def test_a_step_reads_no_file_of_a_template_again(monkeypatch, key):
    steps = [of_page(**{key: value}) for value in {"l": (11.5, 12.5), "b": (27.5, 28.5), "s": (0.31, 0.33)}[key[0]]]
    for ask in (walker_answers.pack_walker, walker_answers.printing_outlook):
        ask(steps[0])

    def read(path):
        pytest.fail(f"{path} was read again")

    monkeypatch.setattr(config, "read_toml", read)
    for ask in (walker_answers.pack_walker, walker_answers.printing_outlook):
        ask(steps[1])


def test_a_finding_is_done_by_the_value_that_it_comes_with():
    page = Document(**PAPER | {"walker": "coinbot", "printer": "ender3"})
    page = page._replace(values={"legs.flexible_thickness_mm": 0.2} if page.load_design().has_legs_table else {})
    does = [finding["does"] for finding in walker_answers.printing_outlook(page)["findings"] if finding["does"]]
    assert does
    done = page._replace(values={**page.values, **{each["key"]: each["value"] for each in does}})
    left = [finding["does"] for finding in walker_answers.printing_outlook(done)["findings"]]
    assert not [each for each in does if each in left]
    assert not [each for each in does if "_" in each["words"]]


def test_parts_of_a_spread_name_the_keys_where_what_was_measured_is_written():
    parts = walker_answers.variance_shares(of_page())
    keys = {part["key"] for part in parts}
    assert {"scene.contact.restitution", "legs.flexible_thickness_mm", "material.youngs_modulus_gpa", ""} <= keys
    assert walker_answers.variance_shares(Document(**PAPER | {"walker": "coinbot", "scene": "table-motor"})) == []
