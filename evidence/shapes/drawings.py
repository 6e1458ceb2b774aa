"""Twenty drawings: SVG files as programs write them, two of them without a size, and three pictures."""

import io
import math
from collections.abc import Callable, Sequence

Point = tuple[float, float]


def svg_file(path: str, width: float, height: float, unit: str = "mm", rule: str = "nonzero") -> bytes:
    """File of one path on a page; without a unit it states no size."""
    page = f'width="{width}{unit}" height="{height}{unit}" ' if unit else ""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" {page}viewBox="0 0 {width} {height}">'
        f'<path fill-rule="{rule}" d="{path}"/></svg>'
    ).encode()


def _polygon_path(points: Sequence[Point]) -> str:
    return "M" + " L".join(f"{x:.4f} {y:.4f}" for x, y in points) + " Z"


def _polar_path(radius: Callable[[float], float], size: float, number: int = 240) -> str:
    """Path about the middle of a page, by its radius over the angle."""
    angles = [2.0 * math.pi * step / number for step in range(number)]
    return _polygon_path(
        [(0.5 * size + radius(at) * math.cos(at), 0.5 * size + radius(at) * math.sin(at)) for at in angles]
    )


def _star_path(tips: int, outer: float, inner: float, size: float) -> str:
    steps = [(outer if step % 2 == 0 else inner, math.pi * step / tips) for step in range(2 * tips)]
    return _polygon_path([(0.5 * size + r * math.cos(at), 0.5 * size + r * math.sin(at)) for r, at in steps])


def _comb_path(teeth: int) -> str:
    """Comb with a thin back."""
    points = [(0.0, 0.0), (30.0, 0.0)]
    for tooth in reversed(range(teeth)):
        left = 30.0 * tooth / teeth
        points += [(left + 1.4, 1.5), (left + 1.4, 14.0), (left + 0.4, 14.0), (left + 0.4, 1.5)]
    return _polygon_path(points)


HEART = "M15 27C-5 12 3 0 10 2C13 3 15 6 15 6C15 6 17 3 20 2C27 0 35 12 15 27Z"
FISH = "M3 15Q16 2 27 13L37 8V22L27 17Q16 28 3 15Z"


def _draw_picture(path: Sequence[Sequence[Point]], kind: str) -> bytes:
    """Picture of polygons, dark on light, of 400 x 300 pixels."""
    from PIL import Image, ImageDraw

    image = Image.new("RGB", (1200, 900), (245, 243, 238))
    for polygon in path:
        ImageDraw.Draw(image).polygon([(3.0 * x, 3.0 * y) for x, y in polygon], fill=(40, 52, 70))
    target = io.BytesIO()
    image.resize((400, 300), Image.Resampling.LANCZOS).save(target, kind)
    return target.getvalue()


def _ellipse_points(x: float, y: float, a: float, b: float) -> list[Point]:
    angles = [2.0 * math.pi * step / 90 for step in range(90)]
    return [(x + a * math.cos(at), y + b * math.sin(at)) for at in angles]


def drawing_files() -> dict[str, bytes]:
    """Files of drawings by their names."""
    rabbit = [
        _ellipse_points(180, 180, 110, 60),
        _ellipse_points(290, 130, 45, 40),
        _ellipse_points(320, 70, 12, 50),
        _ellipse_points(285, 65, 12, 50),
    ]
    return {
        "disc-28.svg": svg_file(_polar_path(lambda _: 14.0, 28.0), 28.0, 28.0),
        "hexagon-30x20.svg": svg_file("M0 10L7.5 0H22.5L30 10L22.5 20H7.5Z", 30.0, 20.0),
        "dumb-bell.svg": svg_file(
            "M10 0A10 10 0 1 0 10 20C16 20 16 13 20 13C24 13 24 20 30 20A10 10 0 1 0 30 0"
            "C24 0 24 7 20 7C16 7 16 0 10 0Z",
            40.0,
            20.0,
        ),
        "heart.svg": svg_file(HEART, 30.0, 28.0),
        "star.svg": svg_file(_star_path(5, 16.0, 7.0, 32.0), 32.0, 32.0),
        "fish.svg": svg_file(FISH, 40.0, 30.0),
        "arrow.svg": svg_file("M0 8H18V0L36 13L18 26V18H0Z", 36.0, 26.0),
        "cross.svg": svg_file("M10 0H20V10H30V20H20V30H10V20H0V10H10Z", 30.0, 30.0),
        "ring.svg": svg_file(
            "M0 14A14 14 0 1 0 28 14A14 14 0 1 0 0 14ZM5 14A9 9 0 1 1 23 14A9 9 0 1 1 5 14Z", 28.0, 28.0
        ),
        "gear.svg": svg_file(
            _polar_path(lambda at: 13.0 + 1.5 * math.tanh(4.0 * math.sin(14.0 * at)), 30.0, 700), 30.0, 30.0
        ),
        "flower.svg": svg_file(_polar_path(lambda at: 11.0 + 4.0 * math.cos(6.0 * at), 32.0), 32.0, 32.0),
        "moon.svg": svg_file("M20 2A14 14 0 1 0 20 30A18 18 0 0 1 20 2Z", 24.0, 32.0),
        "bow-tie.svg": svg_file("M0 0L15 9L30 0V18L15 9L0 18Z", 30.0, 18.0),
        "eight.svg": svg_file("M0 0L24 18V0L0 18Z", 24.0, 18.0),
        "overlapping.svg": svg_file("M0 3H22V15H0ZM14 0H34V18H14Z", 34.0, 18.0),
        "smiley-icon.svg": svg_file(
            "M12 1A11 11 0 1 0 12 23A11 11 0 1 0 12 1ZM8 7A1.5 1.5 0 1 1 8 10A1.5 1.5 0 1 1 8 7Z"
            "M16 7A1.5 1.5 0 1 1 16 10A1.5 1.5 0 1 1 16 7ZM6 14H18A6 6 0 0 1 6 14Z",
            24.0,
            24.0,
            "",
            "evenodd",
        ),
        "three-dots.svg": svg_file(
            "".join(f"M{x} 7A5 5 0 1 0 {x + 10} 7A5 5 0 1 0 {x} 7Z" for x in (0, 13, 26)), 36.0, 14.0
        ),
        "comb.svg": svg_file(_comb_path(12), 30.0, 14.0),
        "rabbit.png": _draw_picture(rabbit, "PNG"),
        "leaf.jpg": _draw_picture([[(40, 150), (140, 60), (280, 80), (370, 150), (280, 220), (140, 240)]], "JPEG"),
    }
