"""Frames show the right things at the right place, and stay cheap."""

from __future__ import annotations

import copy
import os
import pickle
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest
from hand_made import Body, World, box, disc, make_world, standard_world, wall

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.rendering import Renderer
from irsim_gym.rendering.scene.frame_layout import lay_out
from irsim_gym.scenario.specs.plot_spec import ObjectPlot, WorldPlot

ROBOT = (0x00, 0x9E, 0x73)
OBSTACLE = (0x47, 0x55, 0x69)
MOVING = (0x64, 0x74, 0x8B)
CARD = (255, 255, 255)


@pytest.fixture
def world() -> World:
    return standard_world()


def colour_at(renderer: Renderer, frame: Bytes, x: float, y: float) -> tuple[int, ...]:
    column, row = renderer.layout.column_row(x, y)
    return tuple(int(level) for level in frame[int(row), int(column)])


def without_scan(world: World, **options: object) -> Renderer:
    world.sensors.clear()
    return world.renderer(**options)


def test_frames_are_fresh_even_pictures(world: World) -> None:
    renderer = world.renderer()
    first = renderer.frame()
    kept = first.copy()
    world.move(0, 5.0, 5.0)
    world.step()
    second = renderer.frame()
    assert first.shape == second.shape == (600, 600, 3)
    assert first.dtype == np.uint8
    assert first.flags.c_contiguous
    assert first.flags.writeable
    assert not np.shares_memory(first, second)
    assert np.array_equal(first, kept)
    assert not np.array_equal(first, second)


def test_bodies_stand_where_they_are(world: World) -> None:
    renderer = without_scan(world)
    frame = renderer.frame()
    assert colour_at(renderer, frame, 2.1, 3.3) == ROBOT
    assert colour_at(renderer, frame, 2.2, 3.5) == CARD
    assert colour_at(renderer, frame, 7.9, 2.6) == OBSTACLE
    assert colour_at(renderer, frame, 7.9, 3.6) == CARD
    assert colour_at(renderer, frame, 5.0, 7.0) == (0xAA, 0x00, 0xFF)
    assert colour_at(renderer, frame, 3.4, 7.45) == MOVING
    assert colour_at(renderer, frame, 10.0, 5.0) == OBSTACLE, "the wall"
    assert colour_at(renderer, frame, 9.0, 1.0) == CARD, "a wall encloses no area"


def test_moved_bodies_leave_nothing_behind(world: World) -> None:
    renderer = without_scan(world)
    renderer.frame()
    world.move(0, 6.0, 5.0, 1.0)
    world.step()
    renderer.clear()
    frame = renderer.frame()
    assert colour_at(renderer, frame, 2.1, 3.3) == CARD
    assert colour_at(renderer, frame, 6.0, 4.7) == ROBOT


def test_a_fixed_body_is_drawn_where_a_new_level_puts_it(world: World) -> None:
    renderer = without_scan(world)
    renderer.frame()
    world.move(1, 7.0, 5.0)
    frame = renderer.frame()
    assert colour_at(renderer, frame, 7.9, 2.6) == CARD
    assert colour_at(renderer, frame, 7.9, 4.6) == OBSTACLE


def test_absent_bodies_are_not_drawn(world: World) -> None:
    renderer = without_scan(world)
    world.model.present[0, [0, 1, 3]] = False
    frame = renderer.frame()
    for x, y in ((2.1, 3.3), (7.9, 2.6), (3.4, 7.45), (8.1, 8.1)):
        assert colour_at(renderer, frame, x, y) == CARD
    assert colour_at(renderer, frame, 5.0, 7.0) == (0xAA, 0x00, 0xFF)


def test_rows_beyond_the_count_are_not_drawn(world: World) -> None:
    """A random outline with fewer vertices than the most leaves rows of an earlier level behind."""
    renderer = without_scan(world)
    world.model.segment_count[0, 1] = 0
    assert colour_at(renderer, renderer.frame(), 7.9, 2.6) == CARD


def test_the_goal_is_drawn_only_when_asked_for() -> None:
    def picture(plot: ObjectPlot) -> tuple[int, ...]:
        robot = Body(disc(0.3), (2.0, 2.0, 0.0), robot=True, movable=True, goal=(8.0, 8.0), color="#009E73", plot=plot)
        renderer = make_world([robot], lidar=False).renderer()
        return colour_at(renderer, renderer.frame(), 8.0, 7.85)

    assert picture(ObjectPlot()) == CARD
    assert picture(ObjectPlot(show_goal=True)) != CARD
    red, green, blue = picture(ObjectPlot(show_goal=True, goal_color="red"))
    assert red > green == blue


def test_plot_options_decide_colours() -> None:
    body = Body(box(4.0, 4.0), (5.0, 5.0, 0.0), plot=ObjectPlot(obj_color="#123456"))
    renderer = make_world([body], lidar=False).renderer()
    assert colour_at(renderer, renderer.frame(), 5.0, 5.0) == (0x12, 0x34, 0x56)


def test_trajectory_and_its_end_at_a_new_episode() -> None:
    shown = ObjectPlot(show_trajectory=True, traj_alpha=0.9)
    robot = Body(disc(0.2), (1.0, 5.0, 0.0), robot=True, movable=True, color="#009E73", plot=shown)
    world = make_world([robot], lidar=False)
    renderer = world.renderer()
    for k in range(60):
        world.move(0, 1.0 + 0.1 * k, 5.0)
        world.step()
        frame = renderer.frame()
    old, new = colour_at(renderer, frame, 1.5, 5.0), colour_at(renderer, frame, 5.5, 5.0)
    assert CARD[0] > old[0] > new[0], "it fades towards its beginning"
    world.state.step[:] = 0
    assert colour_at(renderer, renderer.frame(), 5.5, 5.0) == CARD, "a step count that goes back is a new episode"


def test_trail_of_outlines() -> None:
    shown = ObjectPlot(show_trail=True, trail_freq=5, trail_fill=True, trail_color="#FF0000", trail_alpha=1.0)
    robot = Body(disc(0.2), (1.0, 5.0, 0.0), robot=True, movable=True, color="#009E73", plot=shown)
    world = make_world([robot], lidar=False)
    renderer = world.renderer()
    for k in range(12):
        world.move(0, 1.0 + 0.5 * k, 5.0)
        frame = renderer.frame()
        world.step()
    assert colour_at(renderer, frame, 1.0, 5.0) == colour_at(renderer, frame, 3.5, 5.0) == (255, 0, 0)
    assert colour_at(renderer, frame, 2.3, 5.0) == CARD


def test_beams_end_on_what_they_hit(world: World) -> None:
    scan = world.renderer().scene().scans[0]
    assert scan.surrounds
    assert scan.hits.sum() == len(scan.hits) // 3
    assert np.allclose(np.linalg.norm(scan.ends - scan.origin, axis=1), np.where(scan.hits, 1.0, 2.0))
    assert np.allclose(scan.origin, [2.0, 3.0])
    renderer = world.renderer()
    hit = scan.ends[4]
    assert colour_at(renderer, renderer.frame(), hit[0], hit[1]) != CARD


def test_a_mounted_sensor_turns_with_its_body(world: World) -> None:
    world.sensors[0].options[0].offset = (0.5, 0.0, np.pi / 2)
    world.move(0, 2.0, 3.0, np.pi / 2)
    scan = world.renderer().scene().scans[0]
    assert np.allclose(scan.origin, [2.0, 3.5])
    assert np.allclose(scan.ends[0] - scan.origin, [1.0, 0.0]), "the first beam, -pi, of a sensor that looks back"


@pytest.mark.parametrize("status", ["success", "collision", "timeout", "left_world"])
def test_outcomes_tint_the_frame(world: World, status: str) -> None:
    renderer = without_scan(world)
    assert colour_at(renderer, renderer.frame(status="running"), 5.0, 1.0) == CARD
    assert colour_at(renderer, renderer.frame(status=status), 5.0, 1.0) != CARD


def test_status_is_read_from_the_state(world: World) -> None:
    renderer = world.renderer()
    assert renderer.scene().status == "running"
    world.state.collided[0, 0], world.state.hit[0, 0] = True, 1
    assert renderer.scene().status == "collision"
    assert [view.body for view in renderer.scene().struck] == [1, 0]
    world.state.arrived[0, 0] = True
    assert renderer.scene().status == "arrived"


def test_frames_are_the_same_again(world: World) -> None:
    renderer = world.renderer()
    first = renderer.frame()
    assert np.array_equal(first, renderer.frame())
    assert np.array_equal(first, world.renderer().frame())
    renderer.close()
    renderer.close()
    assert np.array_equal(first, renderer.frame())


def test_a_frame_does_not_depend_on_the_ones_before(world: World) -> None:
    renderer, fresh = world.renderer(), world.renderer()
    world.state.collided[0, 0], world.state.hit[0, 0] = True, 2
    renderer.frame(status="collision")
    world.state.collided[:], world.state.hit[:] = False, -1
    renderer.clear()
    assert np.array_equal(renderer.frame(status="running"), fresh.frame(status="running"))


def test_worlds_of_a_batch_are_drawn_in_turns() -> None:
    world = make_world([Body(box(2.0, 2.0), (5.0, 5.0, 0.0))], n_worlds=20, lidar=False)
    renderer = world.renderer()
    for w in range(20):
        world.model.present[w, 0] = w % 2 == 0
    for w in (*range(20), 3, 2, 19):
        expected = OBSTACLE if w % 2 == 0 else CARD
        assert colour_at(renderer, renderer.frame(w), 5.0, 5.0) == expected


def test_reading_writes_nothing(world: World) -> None:
    before = copy.deepcopy((world.model, world.state))
    world.renderer().frame()
    for mine, theirs in zip(before, (world.model, world.state), strict=True):
        for name in mine.columns():
            assert getattr(mine, name).tobytes() == getattr(theirs, name).tobytes(), name


@pytest.mark.parametrize(
    ("bounds", "size"),
    [
        ((0.0, 0.0, 10.0, 10.0), None),
        ((-30.0, 5.0, -10.0, 10.0), None),
        ((2.0, -40.0, 6.0, -10.0), None),
        ((0.0, 0.0, 0.5, 0.5), (401, 333)),
        ((0.0, 0.0, 400.0, 10.0), (1000, 800)),
    ],
)
def test_any_world_fits_on_the_frame(bounds: tuple[float, float, float, float], size: tuple[int, int] | None) -> None:
    span = min(bounds[2] - bounds[0], bounds[3] - bounds[1])
    x, y = bounds[0] + 0.3 * span, bounds[3] - 0.3 * span
    world = make_world([Body(box(0.4 * span, 0.4 * span), (x, y, 0.0))], bounds=bounds, lidar=False)
    renderer = world.renderer(size=size)
    frame = renderer.frame()
    assert frame.shape[0] % 2 == frame.shape[1] % 2 == 0
    assert colour_at(renderer, frame, x, y) == OBSTACLE
    if size is not None:
        assert abs(frame.shape[1] - size[0]) <= 1
        assert abs(frame.shape[0] - size[1]) <= 1
    layout = renderer.layout
    left, bottom = layout.column_row(bounds[0], bounds[1])
    right, top = layout.column_row(bounds[2], bounds[3])
    assert 0 < left < right < layout.width
    assert 0 < top < bottom < layout.height
    assert (right - left) / (bottom - top) == pytest.approx((bounds[2] - bounds[0]) / (bounds[3] - bounds[1]))


def test_figure_pixels_and_bare_frames() -> None:
    body = Body(disc(1.0), (5.0, 5.0, 0.0))
    plot = WorldPlot(figure_pixels=(320, 240), no_axis=True, show_title=False)
    assert make_world([body], lidar=False, plot=plot).renderer().frame().shape == (240, 320, 3)
    bare = lay_out(np.array([0.0, 0.0, 10.0, 10.0]), axis=False, title=False)
    assert bare.width < lay_out(np.array([0.0, 0.0, 10.0, 10.0])).width


def test_it_is_copied_and_pickled_without_its_memory(world: World) -> None:
    renderer = world.renderer()
    frame = renderer.frame()
    for other in (copy.deepcopy(renderer), pickle.loads(pickle.dumps(renderer))):
        assert other._painter is None
        assert np.array_equal(other.frame(), frame)


def test_an_empty_world_can_be_drawn() -> None:
    assert make_world([], lidar=False).renderer().frame().shape == (600, 600, 3)


def test_a_wall_alone() -> None:
    world = make_world([Body(wall((1.0, 1.0), (9.0, 1.0)), color="red")], lidar=False)
    renderer = world.renderer()
    assert colour_at(renderer, renderer.frame(), 5.0, 1.0) == (255, 0, 0)


def test_neither_display_nor_pyplot_nor_settings() -> None:
    """In a process without a display, with a matplotlib backend that needs one, whatever was imported before."""
    script = """
import sys
import matplotlib
matplotlib.rcParams["lines.linewidth"] = 9
matplotlib.rcParams["text.usetex"] = True
import hand_made, zlib
print(zlib.crc32(hand_made.standard_world().renderer().frame()))
assert "matplotlib.pyplot" not in sys.modules
"""
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
    environment |= {"MPLBACKEND": "tkagg", "PYTHONPATH": str(Path(__file__).parent)}
    done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    assert int(done.stdout) == zlib.crc32(standard_world().renderer().frame())
