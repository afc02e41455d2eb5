"""A scan of radial velocities is drawn in their colours."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hand_made import Body, World, disc, make_world

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.rendering import Renderer
from irsim_gym.scenario import load_scenario

AWAY, NEARER, REST = (0xCC, 0x33, 0x11), (0x00, 0x72, 0xB2), (0x56, 0xB4, 0xE9)
CARD = (255, 255, 255)
ANGLES = {"away": 0.0, "nearer": 0.5 * np.pi, "rest": np.pi}


def scanned(**plot: Any) -> World:
    """Three beams of 3 m hit what goes away, comes nearer and rests; the fourth, downwards, is free."""
    robot = Body(disc(0.1), (5.0, 5.0, 0.0), robot=True, movable=True)
    world = make_world([robot])
    group = world.sensors[0]
    sensors = {"name": "fmcw_lidar2d", "range_max": 4.0, "plot": plot or None}
    scenario = load_scenario({"robot": {"kinematics": {"name": "diff"}, "sensors": sensors}})
    group.options[0] = scenario.bodies[0].sensors[0]
    group.arrays["angles"] = np.array([*ANGLES.values(), 1.5 * np.pi])
    group.arrays["ranges"] = np.array([[[3.0, 3.0, 3.0, 4.0]]], np.float32)
    group.arrays["radial_velocity"] = np.array([[[5.0, -2.0, 0.0, 0.0]]])
    return world


def along(renderer: Renderer, frame: Bytes, angle: float, way: float) -> tuple[int, ...]:
    """Return the darkest colour across a beam, ``way`` metres from the sensor."""
    column, row = renderer.layout.column_row(5.0 + way * np.cos(angle), 5.0 + way * np.sin(angle))
    patch = frame[int(row) - 2 : int(row) + 3, int(column) - 2 : int(column) + 3].reshape(-1, 3)
    return tuple(int(level) for level in patch[patch.astype(int).sum(axis=1).argmin()])


def test_beams_have_the_colour_of_their_sign() -> None:
    renderer = scanned(velocity_linewidth=3.0).renderer()
    frame = renderer.frame()
    for name, colour in (("away", AWAY), ("nearer", NEARER), ("rest", REST)):
        assert along(renderer, frame, ANGLES[name], 1.5) == pytest.approx(colour, abs=2), name
    free = along(renderer, frame, 1.5 * np.pi, 1.5)
    assert min(free) > 225, "nearly invisible"
    assert renderer.frame().tobytes() == frame.tobytes()


def test_half_the_full_speed_is_half_the_colour() -> None:
    renderer = scanned(velocity_linewidth=3.0, velocity_color_max=10.0).renderer()
    middle = [(a + b) / 2 for a, b in zip(AWAY, REST, strict=True)]
    assert along(renderer, renderer.frame(), 0.0, 1.5) == pytest.approx(middle, abs=2)


def test_the_free_beams_look_as_given() -> None:
    renderer = scanned(no_hit_color="#FF0000", no_hit_alpha=1.0, no_hit_linewidth=3.0).renderer()
    assert along(renderer, renderer.frame(), 1.5 * np.pi, 3.5) == (255, 0, 0)


def test_marks_look_as_given() -> None:
    marked = {"velocity_marker_size": 100.0, "positive_velocity_color": "#00FF00"}
    renderer = scanned(**marked).renderer()
    assert along(renderer, renderer.frame(), 0.0, 3.0) == (0, 255, 0)
    edged = scanned(**marked, velocity_marker_edge_color="#0000FF", velocity_marker_edge_width=4.0).renderer()
    assert along(edged, edged.frame(), 0.0, 3.15) == (0, 0, 255)
    bare = scanned(**marked, show_velocity_markers=False).renderer()
    assert along(bare, bare.frame(), 0.0, 3.15) == CARD


def test_without_colours_it_is_a_lidar_with_marks() -> None:
    renderer = scanned(velocity_color=False, color="#0000FF", show_velocity_markers=False).renderer()
    red, green, blue = along(renderer, renderer.frame(), 0.75 * np.pi, 1.0)
    assert blue > red == green, "the area that it sees"


def test_hits_have_the_opacity_that_is_given() -> None:
    full, faint = scanned(velocity_linewidth=3.0).renderer(), scanned(velocity_linewidth=3.0, alpha=0.3).renderer()
    assert along(faint, faint.frame(), 0.0, 1.5)[1] > along(full, full.frame(), 0.0, 1.5)[1] + 80
