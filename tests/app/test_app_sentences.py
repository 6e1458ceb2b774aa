"""Words of the page: speeds in a sentence, and no key of a file or flag of a shell."""

import pytest

from walkergen.app import sentences
from walkergen.core.theory.prediction import Prediction, make_speed
from walkergen.files import templates


def row(middle, low, high, by="surrogate", nominal=None, falls=0.0):
    """Prediction by its median, the ends of 68 % and those of 95 % of the speed as designed."""
    designed, least, most = (None, None, None) if nominal is None else nominal
    numbers = dict.fromkeys(Prediction._fields)
    return Prediction(**numbers)._replace(
        speed=make_speed("speed", middle, None, (low, low, high, high)),
        speed_by=by,
        nominal=make_speed("nominal", designed, None, (least, least, most, most)),
        falls=falls,
    )


@pytest.mark.parametrize(
    ("asked", "kind", "words"),
    [
        (row(56.8, 39.3, 73.4), "forward", "about 57 mm/s to the right; half of the prints run between 45 and 68."),
        (row(-12.0, -20.0, -6.0), "backward", "runs backward, about 12 mm/s to the left; half"),
        (
            row(0.4, -2.0, 3.0, nominal=(0.3, -0.5, 1.1)),
            "stands",
            "stands, with bounds between 2.0 to the left and 3.0 to the right.",
        ),
        (row(0.0, 0.0, 0.0, "statics", (0.0, 0.0, 0.0)), "stands", "stands."),
        # Prints of either sign, of a design that runs: no verdict of its own
        (row(4.0, -2.0, 9.0, nominal=(5.0, 4.0, 6.0)), "forward", "about 4.0 mm/s to the right; half of the prints"),
        (row(9.5, 5.0, 15.0), "forward", "about 9.5 mm/s"),
        (row(9.96, 5.0, 15.0), "forward", "about 10 mm/s"),
        (row(None, None, None), "unknown", "Its speed is not known yet"),
    ],
)
def test_a_speed_is_a_sentence(asked, kind, words):
    speed = sentences.format_speed(asked)
    assert speed.kind == kind
    assert words in speed.text


def test_a_walker_that_falls_is_said_to():
    speed = sentences.format_speed(row(None, None, None, falls=0.75))
    assert speed == ("falls over in 75 % of its runs.", "falls", True)


def test_a_speed_that_a_run_has_yet_to_tell_is_not_sure():
    assert not sentences.format_speed(row(None, None, None, "theory")).sure
    assert sentences.format_speed(row(57.0, 39.0, 78.0)).sure


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("legs.tilt_deg = 89: must be >= -85 and <= 85", "tilt of the legs = 89: must be between -85 and 85"),
        ("raise material.youngs_modulus_sd_gpa to 0.6", "raise deviation of Young's modulus of the material to 0.6"),
        ("set thin_walls = true; or 0.45 mm would do", "switch on “Detect thin walls”; or 0.45 mm would do"),
        (
            'wall_generator = "classic" with thin_walls = true prints it',
            "the perimeter generator (wall generator in Orca and Bambu) Classic with “Detect thin walls” on prints it",
        ),
        ("set brim_width_mm, and cut it off every leg", "give it a brim, and cut it off every leg"),
        ("scene.drive: a motor has one; add a table [motor]", "drive: a motor has one; add a table motor"),
        ("legs[2].along_mm = 9: lies beyond", "along of leg 2 = 9: lies beyond"),
        ("bounds are wide; family --simulate puts runs in its place", "bounds are wide"),
        ("a leg of 0.4 mm, well-known", "a leg of 0.4 mm, well-known"),
    ],
)
def test_sentences_hold_no_key_and_no_flag(text, words):
    assert sentences.to_plain_text(text) == words


def test_every_walker_and_scene_has_a_plain_name():
    for kind in ("walkers", "scenes"):
        for name in templates.names(kind):
            assert sentences.format_title(name).endswith(f" ({name})")
