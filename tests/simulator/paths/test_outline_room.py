"""Outlines at a pose and their room, worked out by hand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from irsim_gym.base.arraytypes import BodyOutline
from irsim_gym.base.kernels.structs import Struct
from irsim_gym.simulator.cell_paths.outline_room import PoseShape, largest_disc, lay_outline, room_at_pose
from tests.simulator.paths.scenes import Parts, Scene

SQUARE = [[-0.5, -0.5, 0.5, -0.5], [0.5, -0.5, 0.5, 0.5], [0.5, 0.5, -0.5, 0.5], [-0.5, 0.5, -0.5, -0.5]]


def outline(segments: Any, discs: Any, *, skipped: int = 0) -> BodyOutline:
    """Return an outline after as many rows of other bodies."""
    rows, circles = np.full((skipped + len(segments), 4), np.nan), np.full((skipped + len(discs), 3), np.nan)
    rows[skipped:], circles[skipped:] = np.reshape(segments, (-1, 4)), np.reshape(discs, (-1, 3))
    return BodyOutline(rows, skipped, len(segments), circles, skipped, len(discs), True)


def blank(own: BodyOutline) -> BodyOutline:
    """Return room for an outline."""
    segments, discs = np.zeros((own.n_segments, 4)), np.zeros((own.n_discs, 3))
    return BodyOutline(segments, 0, own.n_segments, discs, 0, own.n_discs, True)


def test_an_outline_is_turned_and_moved() -> None:
    """A quarter turn to the left: (x, y) becomes (-y, x)."""
    own = outline([[3, 2, 4, 7]], [[3, 2, 0.5]], skipped=2)
    laid = blank(own)
    lay_outline(own, (10.0, 20.0, np.pi / 2), laid)
    assert laid.segments[0] == pytest.approx([8, 23, 3, 24])
    assert laid.discs[0] == pytest.approx([8, 23, 0.5])
    lay_outline(own, (10.0, 20.0, np.arctan2(3, 4)), laid)  # cosine 0.8, sine 0.6
    assert laid.segments[0] == pytest.approx([11.2, 23.4, 9.0, 28.0])
    assert laid.discs[0] == pytest.approx([11.2, 23.4, 0.5])


@dataclass
class Bodies(Parts):
    """What ``room_at_pose`` reads of model and state."""

    reach: Any


def test_the_room_at_a_pose_is_that_to_the_nearest_obstacle() -> None:
    """A square of 1 m among discs of 0.5 m about (3, 0) and (0, 4): they are 2 m to its right and 3 m above it."""
    scene = Scene().disc(3, 0, 0.5).disc(0, 4, 0.5)
    world = scene.obstacles.model
    bodies: Any = Bodies(
        **{name: getattr(world, name) for name in Bodies.__dataclass_fields__ if name not in ("pose", "reach")},
        pose=np.array([[[3.0, 0.0, 0.0], [0.0, 4.0, 0.0]]]),
        reach=np.full((1, 2), 0.5),
    )
    obstacles, own = scene.obstacles._replace(model=bodies, state=bodies), outline(SQUARE, [])
    shape = PoseShape(own, blank(own), np.sqrt(0.5))
    assert room_at_pose(obstacles, shape, (0.0, 0.0, 0.0), 9.0) == pytest.approx(2.0)
    assert room_at_pose(obstacles, shape, (0.0, 0.0, np.pi / 4), 9.0) == pytest.approx(2.5 - np.sqrt(0.5))
    assert room_at_pose(obstacles, shape, (0.0, 2.0, 0.0), 9.0) == pytest.approx(1.0)
    assert room_at_pose(obstacles, shape, (0.0, 0.0, 0.0), 1.5) == 1.5
    assert room_at_pose(obstacles, shape, (2.2, 0.0, 0.0), 9.0) == 0.0
    obstacles.blocks[0] = False
    assert room_at_pose(obstacles, shape, (0.0, 0.0, 0.0), 9.0) == pytest.approx(3.0)


@dataclass
class Shapes(Struct):
    """What ``largest_disc`` reads of a model."""

    local_segments: Any
    segment_start: Any
    segment_count: Any
    local_discs: Any
    disc_start: Any
    disc_count: Any
    solid: Any


@pytest.mark.parametrize(
    ("corners", "discs", "radius"),
    [
        ([(-3, -2), (4, -2), (4, 1), (-3, 1)], [], 1.0),
        ([(-3, -2), (1.5, -2), (1.5, 5), (-3, 5)], [], 1.5),
        ([(-4, 0), (0, -3), (4, 0), (0, 3)], [], 2.4),  # a rhombus: 4 * 3 / 5
        ([(1, 0), (2, 0), (2, 1)], [], 0.0),  # the origin is outside
        ([(1, 0), (2, 0), (2, 1)], [(0.3, 0.4, 2.0), (0.0, 0.0, 1.0)], 1.5),
        ([(-3, -2), (4, -2), (4, 1), (-3, 1)], [(0.0, 0.0, 0.5)], 1.0),
    ],
)
def test_the_largest_disc_about_the_origin(corners: Any, discs: Any, radius: float) -> None:
    vertices = np.array(corners, np.float64)
    model: Any = Shapes(
        local_segments=np.hstack([vertices, np.roll(vertices, -1, axis=0)])[None],
        segment_start=np.zeros(1, np.int64),
        segment_count=np.full((1, 1), len(vertices)),
        local_discs=np.reshape(np.array(discs, np.float64), (1, -1, 3)),
        disc_start=np.zeros(1, np.int64),
        disc_count=np.full((1, 1), len(discs)),
        solid=np.ones(1, np.bool_),
    )
    assert largest_disc(model, 0, 0) == pytest.approx(radius)
