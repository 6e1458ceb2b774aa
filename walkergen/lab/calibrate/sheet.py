"""Sheet on how to measure a calibration plate with a ruler, a scale and a phone, step by step."""

from collections.abc import Sequence

from walkergen.analysis import beams
from walkergen.lab.calibrate import form, parts
from walkergen.lab.calibrate.parts import Drawn
from walkergen.printing.printers import Printer
from walkergen.printing.sheet import table
from walkergen.walker.design import Design

ORDINARY = (
    ("1 cm of office paper, 80 g/m2, as wide as A4 (21 cm)", 0.168),
    ("nut M3", 0.38),
    ("nut M4", 0.81),
    ("nut M5", 1.23),
    ("1 euro cent", 2.30),
    ("dime (US)", 2.268),
    ("cent (US)", 2.50),
    ("nut M6", 2.5),
    ("2 euro cents", 3.06),
    ("5 euro cents", 3.92),
    ("10 euro cents", 4.10),
    ("nickel (US)", 5.00),
    ("nut M8", 5.2),
    ("quarter (US)", 5.67),
    ("20 euro cents", 5.74),
    ("1 euro", 7.50),
    ("50 euro cents", 7.80),
    ("2 euros", 8.50),
    ("nut M10", 11.6),
    ("nut M12", 17.3),
)
"""Weights (g) at hand: coins by their mints, nuts of steel by DIN 934, paper by its grammage."""

NEAR = 0.35
"""Relative distance up to which an ordinary weight is named for one that is wanted."""


def near(grams: float) -> str:
    """Ordinary weight next to one that is wanted, g; "" where none is near."""
    name, weight = min(ORDINARY, key=lambda pair: abs(pair[1] - grams))
    return f"{name} ({weight:g})" if abs(weight - grams) <= NEAR * grams else ""


def to_markdown(drawn: Sequence[Drawn], design: Design, printer: Printer) -> str:
    """Sections on measuring, after those of the print."""
    sections = [
        _parts(drawn, design, printer),
        _sizes(),
        _bend(drawn),
        _ring(drawn),
        _density(),
        _friction(),
        _drop(),
        _after(),
    ]
    return "\n\n".join(sections) + "\n"


def _parts(drawn: Sequence[Drawn], design: Design, printer: Printer) -> str:
    rows = [
        (
            part.name,
            f"{part.strip.thickness:g} x {part.strip.width:g}",
            f"{part.strip.length:g}",
            f"number {part.name.rpartition('_')[2]} on its block",
        )
        for part in drawn
    ]
    long, wide, high = parts.block_size(printer)
    rows.append(("block", f"{long:g} x {wide:g} x {high:g}", "", "the plain block"))
    walker = f"{design.name}, {design.tilt_deg:g} deg, {design.kind} legs"
    rows.append(("walker", walker, "", "the walker"))
    return (
        "## Measure: the parts\n\n"
        + table(("part", "drawn, mm", "free length, mm", "which"), rows)
        + f"\n\nWrite every reading into `{form.FILE}`, a row each; more rows of a kind are more "
        "tries, and are averaged. `error` is how well you read it, one standard deviation: the "
        "form has what ruler, caliper and phone give; change it where yours differ. Rows that you "
        "leave empty are not estimated, nothing else is lost. Let the parts cool for an hour."
    )


def _sizes() -> str:
    return (
        "## Strips: sizes (caliper, ruler)\n\n"
        "1. `thickness_mm`: three places along each strip, with the caliper's jaws wide over the "
        "layers. It counts by its cube: 0.02 mm of 0.4 mm are 15 % of Young's modulus.\n"
        "2. `width_mm`: the height of the print. `free_length_mm`: from the block's face to the "
        "end of the strip."
    )


def _bend(drawn: Sequence[Drawn]) -> str:
    rows = [
        (
            part.name,
            f"{part.light_g:.2g}",
            near(part.light_g),
            f"{part.heavy_g:.2g}",
            near(part.heavy_g),
            f"{parts.BEND * part.strip.length:.1f}",
        )
        for part in drawn
    ]
    return (
        "## Strips: deflection under a weight (ruler)\n\n"
        "1. Clamp the block to the edge of a table, the whole block on the table, its face over "
        "the edge; the strip sticks out level, its flat side up.\n"
        "2. Hold a ruler upright beside the strip, 2 mm from the tip. Read the height of the "
        "strip's lower edge there: `unloaded_mm`. (So its own weight drops out.)\n"
        "3. Hang the weight on a loop of thread there, or tape it on, its middle there; `weight_g` "
        "is all that hangs, `at_mm` the distance from the block's face to the thread.\n"
        "4. Read the height again, within ten seconds: `reading`. Plastic creeps: what you read "
        "after a minute is a softer strip. Take the weight off, let it rest, repeat.\n"
        f"5. Two weights or more a strip. Not beyond {beams.LARGEST_BEND:.0%} of `at_mm`: such "
        "rows are refused.\n\n"
        + table(("strip", "light, g", "as", "heavy, g", "as", "sinks by about, mm"), rows)
        + "\n\nWeigh the weights if you can; a coin is as heavy as its mint says within 1 %, "
        "which is assumed of all weights. Paper of 80 g/m2: 5 x 5 cm are 0.20 g, 10 x 10 cm 0.80 g."
    )


def _ring(drawn: Sequence[Drawn]) -> str:
    rows = [
        (part.name, f"{part.ring_hz:.0f}", f"{20.0 / part.ring_hz:.2f}", f"{part.ring_hz * 4.0:.0f}") for part in drawn
    ]
    return (
        "## Strips: ring of a plucked strip (phone)\n\n"
        "1. Clamp the block as hard as you can: a strip that loses its swing within five swings "
        "is not held. Nothing hangs on it (or what does stands in `weight_g`, right at the end).\n"
        "2. Film from the side, along the table, in slow motion (240 pictures a second). Pluck it "
        "by 2 mm.\n"
        "3. Count 20 swings, there and back: `swings_20_s` is their real time, that is pictures "
        "over pictures a second: 120 pictures at 240 a second are 0.5 s, however slowly the phone "
        "shows them. `error`: a picture or two.\n"
        "4. `ring_hz` instead, if a microphone's spectrum shows it: below 100 Hz most phones are "
        "deaf. A strip clamped so that half of it is free rings at four times the frequency: write "
        "that as a strip of its own, strip_11, with its sizes and that free length.\n"
        "5. `air_percent` stands there: what the printer's lines leave open of the outline that a "
        "caliper sees. It counts in the mass that swings.\n"
        "6. `swings_to_half`: the number of swings until half the way is left: the legs' "
        "damping.\n\n" + table(("strip", "rings at about, Hz", "20 swings, s", "half as long, Hz"), rows)
    )


def _density() -> str:
    return (
        "## Block: density (scale, caliper)\n\n"
        "`mass_g` of the block, and its `length_mm`, `width_mm`, `height_mm` (of the print) "
        "between faces. A kitchen scale of 1 g tells it to 20 %: give that error, or leave it out; "
        "then the design's density is taken, and the ring is worth less."
    )


def _friction() -> str:
    return (
        "## Block and walker: friction on an incline (phone)\n\n"
        "1. Wipe the surface that will vibrate, the plate itself if it can be tilted, else a piece "
        "of the same sheet: friction belongs to both. Block and walker must be free of grease.\n"
        "2. Lay the phone on it with its level shown, for the angle; set it to zero on the table.\n"
        "3. Lay the block on one of its two large side faces - the walls of the print, as feet "
        "are; not the face that lay on the bed - its length downhill. The walker faces downhill "
        "(feet trail uphill); facing uphill it chatters down earlier.\n"
        "4. Raise one end slowly, tapping beside it with a finger. `slides_deg`: the angle at "
        "which it keeps sliding. Six times, at different places of the surface.\n"
        "5. Or film it as it slides, on a slope of known angle, with a cap (`walkergen track "
        "--markers aruco`): a row `filmed_deg`, and a column `tracks` that names its tracks.csv."
    )


def _drop() -> str:
    return (
        "## Walker: drop test (phone)\n\n"
        "1. Let the walker fall flat by 10 mm onto the plate at rest, a hard one: two blocks of "
        "that height beside it tell the height; `at_mm` is the height of its feet.\n"
        "2. Record the sound. `flight_s`: from the first click to the second. Feet that land one "
        "after the other click twice within 5 ms: that is one landing.\n"
        "3. Six drops, as flat as you can: let it go from a thread at its middle, or pull two "
        "cards from under it. A tilt of 0.1 deg lowers the bounce by half: `calibrate` simulates "
        "drops from the hand, and says what yours tell."
    )


def _after() -> str:
    return (
        f"## Then\n\n`walkergen calibrate {form.FILE} --design DESIGN --scene SCENE` (yours) "
        "writes Young's modulus, density, friction, damping and restitution with their errors "
        "into a design and a scene that `family` and `simulate` take, and says what the readings "
        "do not tell."
    )
