"""Films of capped walkers with known poses: a pinhole camera, a shutter, a codec.

Lengths are mm on the plane of the caps, y up; a camera looks at the middle of the plate, tilted away from the vertical.
Pictures are drawn with GRAIN samples a pixel along each axis, and in several exposures a frame where walkers blur.
"""

from typing import NamedTuple

import numpy as np
from rendered_films import write

from walkergen.core.walker.fittings import Cap
from walkergen.readers.walkers import caps

GRAIN = 2
TEXELS = 10
"""Texels along a cell of a marker."""
BODY = (28.0, 8.0)
"""Length and width of a walker's body, mm; darker than the ground."""


class Camera(NamedTuple):
    """A pinhole camera over the plate."""

    wide: int = 640
    high: int = 480
    focal: float = 700.0
    """Focal length, pixels."""
    height: float = 200.0
    """Distance from the plate's middle, mm."""
    tilt: float = 0.0
    """Angle of its axis from the vertical, rad."""
    roll: float = 0.0
    """Direction of its tilt, rad."""
    middle: tuple[float, float] = (0.0, 0.0)
    """Place on the plate that it looks at, mm."""

    @property
    def homography(self):
        """Map from the plate, mm, y up, to pixels from the upper left corner, y down; (3, 3)."""
        c, s, cr, sr = np.cos(self.tilt), np.sin(self.tilt), np.cos(self.roll), np.sin(self.roll)
        turn = np.array([(cr, sr, 0), (-sr, cr, 0), (0, 0, 1)])
        nod = np.array([(1, 0, 0), (0, c, -s), (0, s, c)])
        whole = turn.T @ nod @ turn
        plane = np.column_stack([whole[:, 0], whole[:, 1], (0.0, 0.0, -self.height)])
        shift = np.array([(1, 0, -self.middle[0]), (0, 1, -self.middle[1]), (0, 0, 1.0)])
        lens = np.array([(self.focal, 0, -0.5 * self.wide), (0, -self.focal, -0.5 * self.high), (0, 0, -1.0)])
        return lens @ plane @ shift

    def pixels(self, places):
        """Pixels of places on the plate, shape (..., 2)."""
        mapped = np.concatenate([places, np.ones((*places.shape[:-1], 1))], -1) @ self.homography.T
        return mapped[..., :2] / mapped[..., 2:]


class Light(NamedTuple):
    """What makes pictures bad."""

    noise: float = 3.0
    """Standard deviation of a pixel."""
    uneven: float = 0.0
    """Relative fall of the light from one corner to the opposite."""
    soft: float = 0.6
    """Deviation of the lens's blur, pixels."""
    exposures: int = 1
    """Exposures a frame, over the shutter's time; 1: no motion blur."""
    ground: float = 120.0
    ink: float = 25.0
    paper: float = 225.0


def texture(number, mirrored=False, covered=False):
    """Brightness (0 ink, 1 paper) of a cap seen from above with its front to the right."""
    white = np.pad(caps.white_cells(number), caps.QUIET_CELLS, constant_values=True)
    cells = np.kron(np.rot90(white, -1), np.ones((TEXELS, TEXELS)))
    if mirrored:
        cells = cells[::-1]
    if covered:
        cells[: len(cells) // 2] = 0.5
    return cells


def picture(walkers, camera, light, hand=None, seed=0):
    """Grey frame of walkers: exposures of lists of (texture, x, y, heading); a hand, (x, y)."""
    import cv2

    fine = (GRAIN * camera.wide, GRAIN * camera.high)
    whole = np.zeros(fine[::-1], np.float32)
    for exposure in walkers:
        canvas = np.full(fine[::-1], light.ground, np.float32)
        for cells, x, y, heading in exposure:
            _body(canvas, camera, x, y, heading, 60.0)
            levels = light.ink + (light.paper - light.ink) * cells.astype(np.float32)
            _paste(canvas, levels, camera, x, y, heading)
        if hand is not None:
            arm = camera.pixels(np.array([hand, (hand[0] + 200.0, hand[1] - 200.0)]))
            ends = [tuple(int(v) for v in GRAIN * end) for end in arm]
            cv2.line(canvas, *ends, 165.0, int(GRAIN * 60))
        whole += canvas / len(walkers)
    small = cv2.resize(whole, (camera.wide, camera.high), interpolation=cv2.INTER_AREA)
    small = cv2.GaussianBlur(small, (0, 0), light.soft)
    row, column = np.mgrid[: camera.high, : camera.wide]
    small *= 1.0 - light.uneven * 0.5 * (row / camera.high + column / camera.wide)
    small += np.random.default_rng(seed).normal(0.0, light.noise or 1e-9, small.shape)
    return small.clip(0, 255).round().astype(np.uint8)


def _corners(x, y, heading, long, wide):
    c, s = np.cos(heading), np.sin(heading)
    unit = 0.5 * np.array([(-long, wide), (long, wide), (long, -wide), (-long, -wide)])
    return unit @ np.array([(c, s), (-s, c)]) + (x, y)


def _body(canvas, camera, x, y, heading, level):
    import cv2

    corners = GRAIN * camera.pixels(_corners(x, y, heading, *BODY)) - 0.5
    cv2.fillPoly(canvas, [np.round(16 * corners).astype(np.int32)], level, shift=4)


def _paste(canvas, levels, camera, x, y, heading):
    """Draw a texture on the plate within the box of pixels that it takes."""
    import cv2

    side = Cap().side
    corners = GRAIN * camera.pixels(_corners(x, y, heading, side, side)) - 0.5
    low = np.floor(corners.min(axis=0)).astype(int) - 1
    high = np.ceil(corners.max(axis=0)).astype(int) + 2
    low, high = np.maximum(low, 0), np.minimum(high, canvas.shape[::-1])
    if (high - low).min() < 2:
        return
    size = len(levels)
    source = np.array([(0, 0), (size, 0), (size, size), (0, size)], np.float32) - 0.5
    turn = cv2.getPerspectiveTransform(source, (corners - low).astype(np.float32))
    box = tuple(int(v) for v in high - low)
    drawn = cv2.warpPerspective(levels, turn, box, flags=cv2.INTER_LINEAR)
    inside = cv2.warpPerspective(np.ones_like(levels), turn, box, flags=cv2.INTER_LINEAR)
    view = canvas[low[1] : high[1], low[0] : high[0]]
    view += inside * (drawn / np.maximum(inside, 1e-6) - view)


def distort_frame(picture, camera, k1):
    """Frame as a lens with radial distortion `k1` sees it: x (1 + k1 r^2) in place of x.

    k1 < 0 is a barrel. The cubic is solved by Newton's method, not by OpenCV.
    """
    import cv2

    row, column = np.mgrid[: camera.high, : camera.wide] + 0.5
    x, y = (column - 0.5 * camera.wide) / camera.focal, (row - 0.5 * camera.high) / camera.focal
    seen = np.maximum(np.hypot(x, y), 1e-12)
    true = seen.copy()
    for _ in range(30):
        true -= (true * (1.0 + k1 * true**2) - seen) / (1.0 + 3.0 * k1 * true**2)
    maps = (
        (true / seen * x * camera.focal + 0.5 * camera.wide - 0.5).astype(np.float32),
        (true / seen * y * camera.focal + 0.5 * camera.high - 0.5).astype(np.float32),
    )
    return cv2.remap(picture, *maps, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)


def circles(count=5, speed=60.0, spacing=31.0):
    """Paths of walkers on neighbouring circles: places and headings, (count, 3), of a time."""
    number = np.arange(count)
    radius, sense = 9.0 + 2.0 * number, np.where(number % 2, 1.0, -1.0)
    x, y = spacing * (number - 0.5 * (count - 1)), 12.0 * (-1.0) ** number

    def poses_at(time):
        turn = sense * speed / radius * time + number
        places = [x + radius * np.cos(turn), y + radius * np.sin(turn)]
        return np.column_stack([*places, turn + 0.5 * np.pi * sense])

    return poses_at


class Shot(NamedTuple):
    """How a film is taken."""

    camera: Camera = Camera()
    light: Light = Light()
    fps: float = 60.0
    shutter: float = 0.5
    """Share of the time between frames with the shutter open."""
    rate: int | None = None
    """Bits a second, thousands; None: nearly all that is seen."""


def draw(ways, frames, shot=Shot(), textures=None, hand=lambda time: None):  # noqa: B008
    """Frames of walkers on their ways, which bear `textures`, by default markers from 0 on."""
    light, pictures = shot.light, []
    for frame in range(frames):
        time = frame / shot.fps
        open_ = np.linspace(-0.5, 0.5, light.exposures) if light.exposures > 1 else np.zeros(1)
        exposures = [ways(time + shot.shutter / shot.fps * part) for part in open_]
        cells = textures or [texture(number) for number in range(len(exposures[0]))]
        walkers = [[(cells[k], *place) for k, place in enumerate(one)] for one in exposures]
        pictures.append(picture(walkers, shot.camera, light, hand(time), seed=frame))
    return pictures


def film(path, ways, frames, shot=Shot(), **drawn):  # noqa: B008
    """Film of walkers on their ways, in a file."""
    return write(path, draw(ways, frames, shot, **drawn), f"N/{shot.fps}", shot.rate)


class Errors(NamedTuple):
    """What tracks are off by, once they are turned and shifted as well as can be."""

    read: float
    """Share of markers that were read."""
    scale: float
    """Relative error of lengths."""
    place_mm: float
    """Root mean square error of places along an axis, without that of the scale."""
    heading_deg: float
    worst_heading_deg: float
    wrong: int
    """Sightings nearer to another walker than to their own."""


def errors(found, ways, fps=60.0):
    """Errors of walkers found by markers in a film of walkers on their ways."""
    truth = np.array([ways(frame / fps) for frame in range(found.looked)])
    seen = [(w.frames, np.full(len(w.frames), w.number)) for w in found.walkers]
    frames, numbers = (np.concatenate(part) for part in zip(*seen, strict=True))
    places = np.concatenate([walker.position for walker in found.walkers])
    headings = np.concatenate([walker.theta for walker in found.walkers])
    true = truth[frames, numbers]
    here, there = places - places.mean(axis=0), true[:, :2] - true[:, :2].mean(axis=0)
    turn = np.arctan2(np.sum(here[:, 1] * there[:, 0] - here[:, 0] * there[:, 1]), np.sum(here * there))
    scale = np.sqrt(np.sum(here**2) / np.sum(there**2))
    c, s = np.cos(turn), np.sin(turn)
    fitted = here / scale @ np.array([(c, -s), (s, c)])
    off = np.angle(np.exp(1j * (headings - turn - true[:, 2])))
    others = truth[frames][..., :2] - truth[frames, numbers][:, None, :2]
    way = np.linalg.norm(others - (fitted - there)[:, None], axis=-1)
    place = float(np.sqrt(np.mean((fitted - there) ** 2)))
    return Errors(
        len(frames) / truth[..., 0].size,
        float(scale) - 1.0,
        place,
        float(np.degrees(np.sqrt(np.mean(off**2)))),
        float(np.degrees(np.abs(off).max())),
        int((way.argmin(axis=1) != numbers).sum()),
    )
