"""Kernels that paint pixel by pixel: texts and marks from masks, images, fog, and maps of cells."""

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Flags, Floats, Ints, Rays
from irsim_gym.base.kernels import kernel


@kernel
def paint_mask(
    picture: Bytes, box: Ints, masks: Bytes, rows: Ints, mask: int, column: int, row: int, colour: Floats
) -> None:
    """Blend a colour into a picture where a mask is.

    Args:
        picture: uint8, shape ``(height, width, 3)``.
        box: Part of the picture that may change.
        masks: Opacities [0, 255] of all masks, one after the other.
        rows: First entry, width, height, and the place of the upper left corner, of each mask, shape ``(n_masks, 5)``.
        mask: Number of the mask.
        column: Column of the mask's origin.
        row: Row of the mask's origin.
        colour: Colour and opacity.
    """
    begin, width, height = rows[mask, 0], rows[mask, 1], rows[mask, 2]
    left, top = column + rows[mask, 3], row + rows[mask, 4]
    for y in range(max(top, box[1]), min(top + height, box[3])):
        place = begin + (y - top) * width - left
        for x in range(max(left, box[0]), min(left + width, box[2])):
            if masks[place + x] > 0:
                # Of 256 parts, so that full opacity replaces the colour and the division is a shift; 128 rounds it.
                share = int(masks[place + x] * colour[3] * (256.0 / 255.0) + 0.5)
                for channel in range(3):
                    old = int(picture[y, x, channel])
                    picture[y, x, channel] = (old * (256 - share) + int(colour[channel] + 0.5) * share + 128) >> 8


@kernel
def paint_image(
    picture: Bytes, box: Ints, pixels: Bytes, rows: Ints, image: int, corner: Floats, along: Floats, across: Floats
) -> None:
    """Paint a rotated and stretched image.

    Args:
        picture: uint8, shape ``(height, width, 3)``.
        box: Part of the picture that may change.
        pixels: Premultiplied colours and opacities of all images, shape ``(n_pixels, 4)``.
        rows: First entry, width and height of each image, shape ``(n_images, 3)``.
        image: Number of the image.
        corner: Position of the lower left corner [pixel], shape ``(2,)``.
        along: Vector to the lower right corner [pixel], shape ``(2,)``.
        across: Vector to the upper left corner [pixel], shape ``(2,)``.
    """
    begin, width, height = rows[image, 0], rows[image, 1], rows[image, 2]
    length2, height2 = along[0] * along[0] + along[1] * along[1], across[0] * across[0] + across[1] * across[1]
    low_x = corner[0] + min(along[0], 0.0) + min(across[0], 0.0)
    high_x = corner[0] + max(along[0], 0.0) + max(across[0], 0.0)
    low_y = corner[1] + min(along[1], 0.0) + min(across[1], 0.0)
    high_y = corner[1] + max(along[1], 0.0) + max(across[1], 0.0)
    seen = high_x > box[0] and low_x < box[2] and high_y > box[1] and low_y < box[3]
    if not (seen and length2 > 0.0 and height2 > 0.0):
        return
    for y in range(max(int(np.floor(low_y)) - 1, box[1]), min(int(np.ceil(high_y)) + 1, box[3])):
        for x in range(max(int(np.floor(low_x)) - 1, box[0]), min(int(np.ceil(high_x)) + 1, box[2])):
            dx, dy = x + 0.5 - corner[0], y + 0.5 - corner[1]
            # Column and row in the image, where its pixels' centres are whole numbers; rows count from the top.
            u = (dx * along[0] + dy * along[1]) / length2 * width - 0.5
            v = (1.0 - (dx * across[0] + dy * across[1]) / height2) * height - 0.5
            if u > -1.0 and v > -1.0 and u < width and v < height:
                _paint_sample(picture, (y, x), pixels, begin, (width, height), u, v)


@kernel
def _paint_sample(
    picture: Bytes, place: tuple[int, int], pixels: Bytes, begin: int, size: tuple[int, int], u: float, v: float
) -> None:
    """Interpolate the colour of an image between four of its pixels, and blend it into a pixel of the picture."""
    y, x = place
    width, height = size
    column, line = int(np.floor(u)), int(np.floor(v))
    right, low = u - column, v - line
    opacity = 0.0
    # The opacity comes first, because blending needs it. Pixels beyond the image count as transparent.
    for channel in range(3, -1, -1):
        value = 0.0
        for i in range(2):
            for j in range(2):
                if 0 <= column + i < width and 0 <= line + j < height:
                    weight = (right if i == 1 else 1.0 - right) * (low if j == 1 else 1.0 - low)
                    value += weight * pixels[begin + (line + j) * width + column + i, channel]
        if channel == 3:
            opacity = value / 255.0
        else:
            picture[y, x, channel] = int(min(value + (1.0 - opacity) * picture[y, x, channel] + 0.5, 255.0))


@kernel
def paint_cells(picture: Bytes, box: Ints, cells: Flags, frame: Floats, view: Floats, colour: Floats) -> None:
    """Paint the cells of a map; a pixel that several cells share is painted if any of them is, so that no wall is lost.

    Args:
        picture: uint8, shape ``(height, width, 3)``.
        box: Part of the picture that may change.
        cells: Which cells are painted, shape ``(n_columns, n_rows)``.
        frame: Corner x, y of the map and width, height of a cell [m].
        view: Column and row of the world's origin [pixel], and pixels per metre.
        colour: Colour and opacity.
    """
    share = int(colour[3] * 256.0 + 0.5)
    for y in range(box[1], box[3]):
        # The cells whose centres lie in the row of pixels; where pixels are smaller than cells, the one in its middle.
        low = int(np.floor(((view[1] - y - 1.0) / view[2] - frame[1]) / frame[3] + 0.5))
        high = max(int(np.floor(((view[1] - y) / view[2] - frame[1]) / frame[3] + 0.5)), low + 1)
        middle = int(np.floor(((view[1] - y - 0.5) / view[2] - frame[1]) / frame[3]))
        if high == low + 1:
            low, high = middle, middle + 1
        for x in range(box[0], box[2]):
            first = int(np.floor(((x - view[0]) / view[2] - frame[0]) / frame[2] + 0.5))
            end = max(int(np.floor(((x + 1.0 - view[0]) / view[2] - frame[0]) / frame[2] + 0.5)), first + 1)
            if end == first + 1:
                first = int(np.floor(((x + 0.5 - view[0]) / view[2] - frame[0]) / frame[2]))
                end = first + 1
            is_set = False
            for i in range(max(first, 0), min(end, cells.shape[0])):
                for j in range(max(low, 0), min(high, cells.shape[1])):
                    is_set = is_set or cells[i, j]
            if is_set:
                for channel in range(3):
                    old = int(picture[y, x, channel])
                    picture[y, x, channel] = (old * (256 - share) + int(colour[channel] + 0.5) * share + 128) >> 8


@kernel
def paint_fog(
    picture: Bytes, box: Ints, explored: Flags, soft: Rays, frame: Floats, view: Floats, colour: Floats
) -> None:
    """Paint a soft cover over unexplored cells; explored cells stay clear.

    Args:
        picture: uint8, shape ``(height, width, 3)``.
        box: Part of the picture that may change.
        explored: Whether each cell is explored, shape ``(n_columns, n_rows)``.
        soft: Scratch memory of the same shape.
        frame: Corner x, y of the cells and width, height of one [m].
        view: Column and row of the world's origin [pixel], and pixels per metre.
        colour: Colour and opacity.
    """
    soften(explored, soft)
    columns, lines = explored.shape[0], explored.shape[1]
    across, along = 1.0 / (view[2] * frame[2]), 1.0 / (view[2] * frame[3])
    first = (0.5 - view[0]) * across - frame[0] / frame[2] - 0.5
    red, green, blue = int(colour[0] + 0.5), int(colour[1] + 0.5), int(colour[2] + 0.5)
    strength = np.float32(256.0 * colour[3])
    for y in range(box[1], box[3]):
        # Place of the pixel among the centres of cells: the cover is interpolated between the four nearest.
        v = min(max((view[1] - y - 0.5) * along - frame[1] / frame[3] - 0.5, 0.0), lines - 1.0)
        j = min(int(v), max(lines - 2, 0))
        m, high = min(j + 1, lines - 1), np.float32(v - j)
        column, low, rise = -1, np.float32(0.0), np.float32(0.0)
        for x in range(box[0], box[2]):
            u = min(max(first + x * across, 0.0), columns - 1.0)
            i = min(int(u), max(columns - 2, 0))
            # Between two centres the cover is linear in x: its value at the left one, and its rise to the right one.
            if i != column:
                k, column = min(i + 1, columns - 1), i
                low = strength * (soft[i, j] + (soft[i, m] - soft[i, j]) * high)
                rise = strength * (soft[k, j] + (soft[k, m] - soft[k, j]) * high) - low
            share = int(low + rise * np.float32(u - i) + np.float32(0.5))
            if share > 0:
                picture[y, x, 0] = (int(picture[y, x, 0]) * (256 - share) + red * share + 128) >> 8
                picture[y, x, 1] = (int(picture[y, x, 1]) * (256 - share) + green * share + 128) >> 8
                picture[y, x, 2] = (int(picture[y, x, 2]) * (256 - share) + blue * share + 128) >> 8


@kernel
def soften(explored: Flags, soft: Rays) -> None:
    """Write the cover of each cell: 0 if it is explored, else more the more of the nine cells around it are not.

    Args:
        explored: Whether each cell is explored, shape ``(n_columns, n_rows)``.
        soft: Cover to write, 0 or 0.5 to 1, of the same shape; cells beyond the border count like those at it.
    """
    columns, lines = explored.shape[0], explored.shape[1]
    for i in range(columns):
        left, right = max(i - 1, 0), min(i + 1, columns - 1)
        # How many of three neighbouring cells are unexplored in the row before, in this one and in the row after.
        hidden = (0 if explored[left, 0] else 1) + (0 if explored[i, 0] else 1) + (0 if explored[right, 0] else 1)
        before = hidden
        for j in range(lines):
            m = min(j + 1, lines - 1)
            after = (0 if explored[left, m] else 1) + (0 if explored[i, m] else 1) + (0 if explored[right, m] else 1)
            soft[i, j] = np.float32(0.0 if explored[i, j] else 0.5 + (before + hidden + after) / 18.0)
            before, hidden = hidden, after
