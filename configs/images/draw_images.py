"""Draw the shipped images of bodies: run ``python configs/images/draw_images.py`` to write them again.

All are seen from above and head to the right. Shapes are given in units of the image's height, x from the rear and
y from the middle to the left, drawn eight times as large and reduced, which smooths their edges.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageChops, ImageDraw, ImageFilter

Points = NDArray[np.float64]
Colour = tuple[int, int, int, int]

LARGER = 8
COLOURS = 256
GLASS, GLASS_LIGHT = (30, 41, 59, 255), (71, 92, 120, 255)
TYRE, CLEAR = (24, 28, 34, 255), (0, 0, 0, 0)
LAMP, TAIL_LAMP = (255, 243, 190, 255), (150, 12, 24, 255)
CARS = {"car_blue.png": (37, 99, 191), "car_red.png": (200, 45, 45), "car_green.png": (26, 138, 84)}
ROBOTS = {"diff_robot0.png": ((0, 148, 136), (240, 246, 246)), "diff_robot1.png": ((232, 132, 28), (52, 58, 68))}


class Canvas:
    """An image that is drawn in units of its height."""

    def __init__(self, width: int, height: int) -> None:
        self._size, self._unit = (width, height), height * LARGER
        self.image = Image.new("RGBA", (width * LARGER, height * LARGER), CLEAR)

    def _pixels(self, points: Points) -> list[tuple[float, float]]:
        return [(float(x) * self._unit, (0.5 - float(y)) * self._unit) for x, y in points]

    def area(self, points: Points, colour: Colour) -> None:
        """Fill an area; a colour with an opacity below 255 is blended."""
        layer = Image.new("RGBA", self.image.size, CLEAR)
        ImageDraw.Draw(layer).polygon(self._pixels(points), fill=colour)
        self.image.alpha_composite(layer)

    def both(self, points: Points, colour: Colour) -> None:
        """Fill an area and its mirror image on the right."""
        self.area(points, colour)
        self.area(points * [1.0, -1.0], colour)

    def shade(self, light: Points, strength: float, blur: float) -> None:
        """Make what is drawn so far lighter (or darker, below 0) within an area with soft edges."""
        mask = Image.new("L", self.image.size, 0)
        ImageDraw.Draw(mask).polygon(self._pixels(light), fill=round(255 * abs(strength)))
        mask = mask.filter(ImageFilter.GaussianBlur(blur * self._unit))
        tone = Image.new("RGBA", self.image.size, (255, 255, 255, 255) if strength > 0 else (0, 0, 0, 255))
        tone.putalpha(ImageChops.multiply(mask, self.image.getchannel("A")))
        self.image.alpha_composite(tone)

    def reduced(self) -> Image.Image:
        """Return the image in its own size."""
        return self.image.convert("RGBa").resize(self._size, Image.Resampling.BOX).convert("RGBA")


def smooth(corners: Sequence[tuple[float, float]], radius: float) -> Points:
    """Return a polygon whose corners are rounded by quadratic curves that begin up to ``radius`` before them."""
    given = np.array(corners)
    points = []
    for before, corner, after in zip(np.roll(given, 1, 0), given, np.roll(given, -1, 0), strict=True):
        ends = []
        for other in (before, after):
            way = other - corner
            length = float(np.linalg.norm(way))
            ends.append(corner + way / length * min(radius, 0.5 * length))
        share = np.linspace(0.0, 1.0, 16)[:, None]
        points.append((1 - share) ** 2 * ends[0] + 2 * share * (1 - share) * corner + share**2 * ends[1])
    return np.vstack(points)


def mirrored(upper: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return a closed outline from its upper half, which is given from the rear to the front."""
    return [*upper, *[(x, -y) for x, y in reversed(upper)]]


def box(x: float, y: float, length: float, width: float, radius: float) -> Points:
    """Return a rectangle with round corners, from its middle."""
    right, top = x + 0.5 * length, y + 0.5 * width
    return smooth([(2 * x - right, 2 * y - top), (right, 2 * y - top), (right, top), (2 * x - right, top)], radius)


def disc(x: float, y: float, radius: float) -> Points:
    """Return a circle."""
    turn = np.linspace(0.0, 2.0 * np.pi, 180, endpoint=False)
    return np.column_stack([x + radius * np.cos(turn), y + radius * np.sin(turn)])


def ring_part(radius: float, width: float, middle: float, span: float) -> Points:
    """Return a piece of a ring about the middle of a square image."""
    turn = np.linspace(middle - 0.5 * span, middle + 0.5 * span, 60)
    outer = np.column_stack([np.cos(turn), np.sin(turn)])
    return np.asarray(np.vstack([radius * outer, (radius - width) * outer[::-1]]) + np.array([0.5, 0.0]))


def shaded(colour: tuple[int, int, int], share: float) -> Colour:
    """Return a colour mixed with white (above 0) or black (below 0)."""
    red, green, blue = (round(level + abs(share) * ((255 if share > 0 else 0) - level)) for level in colour)
    return red, green, blue, 255


def car(colour: tuple[int, int, int]) -> Image.Image:
    """Return a car: 2.5 times as long as wide."""
    canvas = Canvas(320, 128)
    long = 2.5
    hull = mirrored([(0.0, 0.30), (0.06, 0.43), (0.45, 0.462), (1.7, 0.455), (2.25, 0.425), (2.44, 0.31), (long, 0.15)])
    for x in (0.52, 1.95):
        canvas.both(box(x, 0.435, 0.36, 0.11, 0.04), TYRE)
    canvas.both(smooth([(1.57, 0.44), (1.66, 0.44), (1.645, 0.5), (1.56, 0.5)], 0.03), shaded(colour, -0.35))
    canvas.area(smooth(hull, 0.2), shaded(colour, -0.42))
    inner = [(0.025 + x * (long - 0.05) / long, y * 0.945) for x, y in hull]
    canvas.area(smooth(inner, 0.2), shaded(colour, 0.0))
    canvas.shade(box(1.25, 0.0, 2.3, 0.42, 0.2), 0.26, 0.09)
    canvas.both(smooth([(1.72, 0.29), (2.38, 0.2), (2.38, 0.18), (1.72, 0.265)], 0.02), shaded(colour, -0.22))
    glass = mirrored([(0.34, 0.30), (0.5, 0.385), (1.5, 0.395), (1.78, 0.32), (1.8, 0.16)])
    canvas.area(smooth(glass, 0.13), GLASS)
    canvas.area(smooth(mirrored([(1.5, 0.33), (1.74, 0.28), (1.765, 0.12)]), 0.06), GLASS_LIGHT)
    canvas.area(smooth(mirrored([(0.39, 0.24), (0.5, 0.30), (0.58, 0.27)]), 0.05), GLASS_LIGHT)
    roof = mirrored([(0.6, 0.30), (0.72, 0.325), (1.32, 0.33), (1.46, 0.29)])
    canvas.area(smooth(roof, 0.09), shaded(colour, -0.08))
    canvas.shade(box(1.03, 0.0, 0.7, 0.34, 0.1), 0.22, 0.08)
    for x in (0.95, 1.0):
        canvas.both(smooth([(x, 0.32), (x + 0.03, 0.32), (x + 0.03, 0.4), (x, 0.4)], 0.005), shaded(colour, -0.2))
    canvas.both(smooth([(2.25, 0.39), (2.37, 0.36), (2.44, 0.26), (2.46, 0.2), (2.38, 0.24)], 0.03), LAMP)
    canvas.both(smooth([(0.04, 0.24), (0.06, 0.37), (0.11, 0.40), (0.1, 0.25)], 0.03), TAIL_LAMP)
    return canvas.reduced()


def robot(shell: tuple[int, int, int], cover: tuple[int, int, int]) -> Image.Image:
    """Return a round robot with two wheels, a bumper in front, a lidar and a mark of where it heads."""
    canvas = Canvas(160, 160)
    canvas.area(disc(0.5, 0.0, 0.5), shaded(shell, -0.45))
    canvas.area(disc(0.5, 0.0, 0.478), shaded(shell, 0.0))
    canvas.shade(disc(0.44, 0.07, 0.36), 0.3, 0.08)
    canvas.both(box(0.5, 0.405, 0.32, 0.115, 0.04), TYRE)
    for x in (0.40, 0.47, 0.54, 0.61):
        canvas.both(box(x, 0.405, 0.022, 0.115, 0.004), (70, 78, 90, 255))
    canvas.area(ring_part(0.5, 0.05, 0.0, 1.7), TYRE)
    for middle in (-0.5, 0.0, 0.5):
        canvas.area(ring_part(0.488, 0.026, middle, 0.16), LAMP)
    canvas.area(disc(0.5, 0.0, 0.325), shaded(cover, -0.25))
    canvas.area(disc(0.5, 0.0, 0.308), shaded(cover, 0.0))
    canvas.shade(disc(0.46, 0.05, 0.22), 0.16 if sum(cover) < 380 else 0.4, 0.06)
    canvas.area(smooth([(0.785, 0.0), (0.69, 0.11), (0.715, 0.0), (0.69, -0.11)], 0.02), shaded(shell, 0.1))
    canvas.area(disc(0.46, 0.0, 0.165), GLASS)
    canvas.area(disc(0.46, 0.0, 0.14), GLASS_LIGHT)
    canvas.area(disc(0.46, 0.0, 0.085), GLASS)
    canvas.area(disc(0.435, 0.03, 0.026), (190, 210, 232, 255))
    return canvas.reduced()


def paletted(image: Image.Image) -> Image.Image:
    """Return an image of 256 of its colours, a third as large as a file: each pixel gets the nearest one.

    The next colour is always the one that is farthest from those before. No level changes by more than 7 of 255.
    """
    pixels = np.asarray(image).reshape(-1, 4)
    colours, places = np.unique(pixels, axis=0, return_inverse=True)
    shown = colours * np.append(np.repeat(colours[:, 3:] / 255.0, 3, axis=1), np.ones((len(colours), 1)), axis=1)
    chosen, away = [int(shown[:, 3].argmin())], np.full(len(colours), np.inf)
    while len(chosen) < min(COLOURS, len(colours)):
        away = np.minimum(away, ((shown - shown[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(away.argmax()))
    nearest = ((shown[:, None] - shown[chosen]) ** 2).sum(axis=2).argmin(axis=1)
    found = Image.new("P", image.size)
    found.putdata(nearest[places.ravel()].tolist())
    found.putpalette(colours[chosen].ravel().tolist(), "RGBA")
    return found


def draw_all() -> dict[str, Image.Image]:
    """Return all images by file name."""
    images = {name: car(colour) for name, colour in CARS.items()}
    return {**images, **{name: robot(*colours) for name, colours in ROBOTS.items()}}


if __name__ == "__main__":
    for name, image in draw_all().items():
        paletted(image).save(Path(__file__).parent / name, optimize=True)
