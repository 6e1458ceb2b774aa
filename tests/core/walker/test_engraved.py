"""Text engraved into bodies: pockets of the letters' area times their depth in a face, and refusals."""

import numpy as np
import pytest

from walkergen.core.errors import InputError
from walkergen.core.files.config import validate
from walkergen.core.walker import mass, solids
from walkergen.core.walker.design import Design
from walkergen.readers.drawings import outlines
from walkergen.readers.drawings.lettering import text_outline

DISC = {"body": {"outline": "disc", "length_mm": 24.0}, "legs": {"width_mm": 4.0}}


def design_of(base, **marks):
    return validate(base | {"marks": {"kind": "text", **marks}}, Design, "test")


def volume(design):
    return mass.weigh(solids.build(design).walker, 1.0).volume


@pytest.mark.parametrize(("base", "height"), [(DISC, 8.0), ({}, 1.5)])
def test_the_pockets_are_the_letters(base, height):
    marked = design_of(base, text="A8", text_height_mm=height)
    drawn = sum(outlines.area(polygon) for polygon in text_outline("A8", height, False, "text"))
    lost = volume(validate(base, Design, "test")) - volume(marked)
    # Differences of volumes of about 1000 mm3, each known to rounding
    assert lost == pytest.approx(0.4 * drawn, abs=1e-8)


def test_letters_on_a_disc_read_from_above():
    """The stem of an L is on its left, at smaller x; its foot is nearer, at larger z."""
    built = solids.build(design_of(DISC, text="L", text_height_mm=8.0))
    floor = built.body.vertices[np.isclose(built.body.vertices[:, 1], 1.5 - 0.4)]
    x, z = floor[:, 0], floor[:, 2] - 12.0
    stem = floor[z < 0.0]
    assert stem[:, 0].max() < 0.5 * (x.min() + x.max())
    assert built.walker.vertices[:, 1].max() == pytest.approx(1.5)


def test_text_goes_with_its_kind():
    with pytest.raises(InputError, match="go together"):
        validate({"marks": {"kind": "digits", "text": "A"}}, Design, "test")
