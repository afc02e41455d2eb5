"""Common parts of image observations: the view, and painting the world into it.

Pixels are counted from the upper left corner, x to the right and y downwards, as in ``raster``.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from irsim_gym.base.arraytypes import Bytes, CellMap, Cells, Floats, Ints, Point, Rays
from irsim_gym.rendering.raster.areas import add_disc
from irsim_gym.rendering.raster.sheets import add_edge, new_sheet, note, scan_edge
from irsim_gym.simulator.cell_maps.world_maps import map_of
from irsim_gym.tasks.terms import Model, Simulation, State, Struct, Term, kernel, kind, option, row_of
from irsim_gym.tasks.terms.mirrored import IN_WORLD, Mirrored, sectors_exchanged

CORNER = 1.42
"""Upper bound of the ratio of the distances of a square's corner and side from its centre."""
LINE = 1.5
"""Thickness of shapes without thickness, such as walls [pixel]."""


@kind
class SquareImage:
    """What square images around an agent have in common."""

    pixels: int = option(64, ge=8, le=1024, unit="pixel", meaning="Height and width; Stable-Baselines3 needs 36.")
    metres: float = option(8.0, gt=0.0, unit="m", meaning="Height and width of the area shown.")
    rotated: bool = option(True, meaning="The agent's heading points up; otherwise the world's y axis does.")
    goal_channel: bool = option(True, meaning="Show the next goal in a separate channel, the last one.")

    @property
    def needs_goal(self) -> bool:
        """Whether it needs a goal: if it shows one."""
        return self.goal_channel

    @property
    def view(self) -> str:
        """Description of the image's area and orientation."""
        return around(self.metres, self.pixels, self.rotated)

    def mirrored(self, term: Term) -> Mirrored | str:
        """Return the columns of pixels from right to left; a reason if the axes of the world point up and right."""
        return sectors_exchanged(self.pixels) if self.rotated else IN_WORLD


class View(NamedTuple):
    """The view of an image: a point x, y [m], the unit vector that points up, pixels per metre, the point's pixel."""

    x: float
    y: float
    up_x: float
    up_y: float
    scale: float
    middle_x: float
    middle_y: float


class Canvas(NamedTuple):
    """The target of shapes: a sheet that is empty before and after painting, the box of the image, and its view."""

    sheet: Rays
    box: Ints
    camera: View


@dataclass
class Paints(Struct):
    """Memory and colours for painting.

    Attributes:
        box: The whole image: left, top, right, bottom [pixel], shape ``(4,)``.
        sheets: A sheet for each slot, see ``new_sheet``.
        colours: Values of the channels, and the opacity, shape ``(n_colours, n_channels + 1)``.
    """

    box: Ints
    sheets: Rays
    colours: Floats

    @classmethod
    def of(cls, simulation: Simulation, height: int, width: int, colours: Sequence[Sequence[float]]) -> Self:
        """Allocate memory for images of a size [pixel]."""
        sheets = np.stack([new_sheet(height, width)] * simulation.shards.n_slots)
        return cls(np.array([0, 0, width, height], np.int64), sheets, np.array(colours, np.float64))


def around(metres: float, pixels: int, rotated: bool) -> str:
    """Return the description of the area and orientation of an image around a robot."""
    up = "the robot's heading is up, its left is left" if rotated else "the world's y axis is up, x to the right"
    return f"{metres:g} m x {metres:g} m around the robot, {metres / pixels:.3g} m a pixel; {up}"


@kernel(inlined=True)
def view_from(pose: Floats, rotated: bool, scale: float, pixels: int) -> View:
    """Return the view of an agent at a pose; its heading points up if ``rotated``."""
    up_x, up_y = (np.cos(pose[2]), np.sin(pose[2])) if rotated else (0.0, 1.0)
    return View(pose[0], pose[1], up_x, up_y, scale, 0.5 * pixels, 0.5 * pixels)


@kernel(inlined=True)
def clear(picture: Bytes, value: int) -> None:
    """Fill all channels of an image."""
    for row in range(picture.shape[0]):
        for column in range(picture.shape[1]):
            for channel in range(picture.shape[2]):
                picture[row, column, channel] = value


@kernel(inlined=True)
def image_column(view: View, x: float, y: float) -> float:
    """Return the column of a point [m], from the left of the image [pixel]."""
    return view.middle_x + view.scale * ((x - view.x) * view.up_y - (y - view.y) * view.up_x)


@kernel(inlined=True)
def image_row(view: View, x: float, y: float) -> float:
    """Return the row of a point [m], from the top of the image [pixel]."""
    return view.middle_y - view.scale * ((x - view.x) * view.up_x + (y - view.y) * view.up_y)


@kernel
def add_side(canvas: Canvas, a: Point, b: Point) -> None:
    """Add a side of an area from a to b [m] to a sheet; the area is to its left."""
    sheet, box, view = canvas
    x, y = image_column(view, b[0], b[1]), image_row(view, b[0], b[1])
    add_edge(sheet, box, x, y, image_column(view, a[0], a[1]), image_row(view, a[0], a[1]))


@kernel
def add_wall(canvas: Canvas, a: Point, b: Point) -> None:
    """Add a line from a to b [m] to a sheet, with thickness ``LINE`` and slightly extended ends."""
    sheet, box, view = canvas
    px, py = image_column(view, a[0], a[1]), image_row(view, a[0], a[1])
    qx, qy = image_column(view, b[0], b[1]), image_row(view, b[0], b[1])
    dx, dy = qx - px, qy - py
    length = np.sqrt(dx * dx + dy * dy)
    if length > 0.0:
        dx, dy = 0.5 * LINE * dx / length, 0.5 * LINE * dy / length
        px, py, qx, qy = px - dx, py - dy, qx + dx, qy + dy
        # Four sides of the rectangle around the line; (dx, dy) is half of its thickness along it.
        add_edge(sheet, box, px + dy, py - dx, qx + dy, qy - dx)
        add_edge(sheet, box, qx + dy, qy - dx, qx - dy, qy + dx)
        add_edge(sheet, box, qx - dy, qy + dx, px - dy, py + dx)
        add_edge(sheet, box, px - dy, py + dx, px + dy, py - dx)


@kernel
def is_near(canvas: Canvas, x: float, y: float, reach: float) -> bool:
    """Return whether a shape within ``reach`` of a point [m] may be visible in the image."""
    view, box = canvas.camera, canvas.box
    column, row, far = image_column(view, x, y), image_row(view, x, y), reach * view.scale + LINE
    is_beside: bool = column + far <= box[0] or column - far >= box[2]
    return not (is_beside or row + far <= box[1] or row - far >= box[3])


@kernel
def add_body(canvas: Canvas, model: Model, state: State, w: int, b: int) -> None:
    """Add a body of a world to a sheet.

    Reads: model (disc_count, disc_start, reach, segment_count, segment_start, solid), state (discs, pose, segments).
    """
    sheet, box, view = canvas
    reach = model.reach[row_of(model.reach, w), b]
    if not is_near(canvas, state.pose[w, b, 0], state.pose[w, b, 1], reach):
        return
    first = model.segment_start[b]
    is_solid, segments, discs = model.solid[b], state.segments[w], state.discs[w]
    for s in range(first, first + model.segment_count[row_of(model.segment_count, w), b]):
        begin, end = (segments[s, 0], segments[s, 1]), (segments[s, 2], segments[s, 3])
        if is_solid:
            add_side(canvas, begin, end)
        else:
            add_wall(canvas, begin, end)
    first = model.disc_start[b]
    for d in range(first, first + model.disc_count[row_of(model.disc_count, w), b]):
        x, y = discs[d, 0], discs[d, 1]
        add_disc(sheet, box, image_column(view, x, y), image_row(view, x, y), discs[d, 2] * view.scale, 1.0)


@kernel
def add_rectangle(canvas: Canvas, lower_left: Point, upper_right: Point) -> None:
    """Add an upright rectangle with two of its corners [m] to a sheet."""
    sheet, box, view = canvas
    left, low, right, high = lower_left[0], lower_left[1], upper_right[0], upper_right[1]
    half_x, half_y = 0.5 * (right - left), 0.5 * (high - low)
    if not is_near(canvas, left + half_x, low + half_y, np.sqrt(half_x * half_x + half_y * half_y)):
        return
    ax, ay = image_column(view, left, low), image_row(view, left, low)
    bx, by = image_column(view, right, low), image_row(view, right, low)
    cx, cy = image_column(view, right, high), image_row(view, right, high)
    dx, dy = image_column(view, left, high), image_row(view, left, high)
    # One note for all four sides, in place of one for each as ``add_edge`` makes.
    note(sheet, box, min(ax, bx, cx, dx), min(ay, by, cy, dy), max(ax, bx, cx, dx), max(ay, by, cy, dy))
    scan_edge(sheet, box, bx, by, ax, ay)
    scan_edge(sheet, box, cx, cy, bx, by)
    scan_edge(sheet, box, dx, dy, cx, cy)
    scan_edge(sheet, box, ax, ay, dx, dy)


@kernel
def add_cells(canvas: Canvas, cells: Cells, w: int) -> None:
    """Add the occupied cells of the map of world w to a sheet."""
    if cells is not None:
        view, box = canvas.camera, canvas.box
        world_map = map_of(cells, w)
        x, y, width, height, boxes = world_map.x, world_map.y, world_map.width, world_map.height, world_map.boxes
        farthest = max(view.middle_x, box[2] - view.middle_x, view.middle_y, box[3] - view.middle_y)
        seen = CORNER * (farthest + LINE) / view.scale
        for k in range(world_map.n_boxes):
            left, right = x + width * boxes[k, 0], x + width * boxes[k, 1]
            low, high = y + height * boxes[k, 2], y + height * boxes[k, 3]
            size = CORNER * (right - left + high - low)  # most cells are far away in any orientation of the image
            if max(abs(left - view.x), abs(low - view.y)) < seen + size:
                if world_map.radius > 0.0:
                    add_cell_discs(canvas, world_map, k)
                else:
                    add_rectangle(canvas, (left, low), (right, high))


@kernel
def add_cell_discs(canvas: Canvas, cells: CellMap, k: int) -> None:
    """Add the discs in the cells of a map's box to a sheet."""
    view = canvas.camera
    for i in range(cells.boxes[k, 0], cells.boxes[k, 1]):
        for j in range(cells.boxes[k, 2], cells.boxes[k, 3]):
            x, y = cells.x + (i + 0.5) * cells.width, cells.y + (j + 0.5) * cells.height
            column, row = image_column(view, x, y), image_row(view, x, y)
            add_disc(canvas.sheet, canvas.box, column, row, cells.radius * view.scale, 1.0)


@kernel
def add_outside(canvas: Canvas, bounds: Floats) -> None:
    """Add the visible space outside of the world to a sheet."""
    box, view = canvas.box, canvas.camera
    size = (box[2] - box[0] + box[3] - box[1]) / view.scale
    left, low, right, high = bounds[0], bounds[1], bounds[2], bounds[3]
    # Four rectangles around the world, which reach beyond the image wherever its middle is.
    from_x, from_y = min(left, view.x) - size, min(low, view.y) - size
    to_x, to_y = max(right, view.x) + size, max(high, view.y) + size
    add_rectangle(canvas, (from_x, from_y), (left, to_y))
    add_rectangle(canvas, (right, from_y), (to_x, to_y))
    add_rectangle(canvas, (left, from_y), (right, low))
    add_rectangle(canvas, (left, high), (right, to_y))
