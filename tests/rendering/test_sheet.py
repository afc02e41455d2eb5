"""Contact sheets and pictures of ways."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hand_made import Body, World, disc, make_world
from PIL import Image

from irsim_gym.rendering.films.sheet import WIDEST, Moments, contact_sheet, save_sheet, spaced
from irsim_gym.rendering.films.strobe import draw_strobe, save_strobe, strobe
from irsim_gym.rendering.replay.replay_data import Recording
from irsim_gym.rendering.scene.frame_layout import lay_out


def numbered(count: int, wanted: int) -> tuple[list[int], int]:
    """Return which of ``count`` moments are shown, and how many were drawn."""
    moments, drawn = Moments(wanted), []

    def draw(k: int) -> np.ndarray:
        drawn.append(k)
        return np.full((2, 2, 3), k % 251, np.uint8)

    for k in range(count):
        moments.offer(lambda k=k: draw(k))
    return [int(frame[0, 0, 0]) for frame in moments.frames()], len(drawn)


@pytest.mark.parametrize("count", [1, 2, 5, 12, 13, 61, 200])
def test_moments_are_evenly_spaced_from_the_first_to_the_last(count: int) -> None:
    shown, _ = numbered(count, 12)
    assert len(shown) == min(count, 12)
    assert (shown[0], shown[-1]) == (0, count - 1)
    gaps = np.diff(shown)
    assert not len(gaps) or gaps.max() - gaps.min() <= max(0.5 * (count - 1) / 11, 1)


def test_a_long_episode_needs_few_frames() -> None:
    _, drawn = numbered(100_000, 12)
    assert drawn < 12 * 8 + 12 * 4 * 11  # then half as many for each doubling of its length


def test_what_cannot_be_shown() -> None:
    with pytest.raises(ValueError, match="at least 2 moments, got 1"):
        Moments(1)
    with pytest.raises(ValueError, match="at least one frame"):
        Moments().frames()


def test_spaced() -> None:
    assert spaced(11, 3).tolist() == [0, 5, 10]
    assert spaced(2, 12).tolist() == [0, 1]


def test_a_sheet_holds_its_frames_in_order() -> None:
    frames = [np.full((40, 60, 3), shade, np.uint8) for shade in (10, 60, 110, 160, 210)]
    sheet = contact_sheet([frames, frames[:2]], ["", ""], columns=3)
    assert sheet.shape == (3 * 40, 3 * 60, 3)
    middles = sheet[20::40, 30::60, 0]
    assert middles[:2].tolist() == [[10, 60, 110], [160, 210, 246]]  # 246: the paper
    assert middles[2].tolist() == [10, 60, 246]


def test_a_sheet_is_reduced_and_bears_captions(tmp_path: Path) -> None:
    frames = [np.full((600, 900, 3), 255, np.uint8)] * 12
    sheet = contact_sheet([frames], ["dash, level 0: collision"])
    assert sheet.shape[1] <= WIDEST
    assert sheet[:20].min() < 100  # words
    path = save_sheet(sheet, tmp_path / "new" / "sheet.png")
    with Image.open(path) as image:
        assert np.array_equal(np.asarray(image), sheet)
    assert [file.name for file in path.parent.iterdir()] == ["sheet.png"]


@pytest.mark.parametrize(
    ("size", "count", "shape"),
    [
        ((600, 600), 12, (4 * 600, 3 * 600)),  # on a screen of 1440 pixels each is 480 wide
        ((600, 600), 4, (2 * 600, 2 * 600)),
        (
            (300, 1200),
            12,
            (12 * 300, 1200),
        ),  # as large as 600 x 600, so 0.8 * 1200 = 960 wide at least: no room for two
        ((1200, 1200), 12, (4 * 600, 3 * 600)),
        ((200, 240), 5, (200, 5 * 240)),
    ],
)
def test_moments_are_large_enough_to_read(size: tuple[int, int], count: int, shape: tuple[int, int]) -> None:
    frames = [np.full((*size, 3), 255, np.uint8)] * count
    assert contact_sheet([frames], [""]).shape[:2] == shape


@pytest.fixture
def crossed() -> tuple[World, Recording]:
    """A robot that drives from x = 1 to x = 9 along y = 5, and a body that drifts below it."""
    world = make_world(
        [
            Body(disc(0.3), robot=True, movable=True, color="#00FF00"),
            Body(disc(0.4), movable=True, color="#0000FF"),
            Body(disc(0.5), (5.0, 8.0, 0.0), color="#FF0000"),
        ],
        lidar=False,
    )
    renderer, recording = world.renderer(), Recording(world.scenario, ["robot_0"])
    for k in range(81):
        world.move(0, 1.0 + 0.1 * k, 5.0)
        world.move(1, 2.0 + 0.02 * k, 2.0)
        recording.note(renderer.scene(0, "running"), world.state.pose[0], [{}])
        world.step()
    return world, recording


def test_a_strobe_shows_where_bodies_were(crossed: tuple[World, Recording]) -> None:
    world, recording = crossed
    layout = lay_out(world.model.bounds)
    scene = strobe(recording, layout, count=5)
    stood = [view.anchor[0] for view in scene.ghosts if view.name == "robot_0"]
    assert stood == pytest.approx([1.0, 3.0, 5.0, 7.0])
    assert [label.text for label in scene.labels] == ["0.0 s", "2.0 s", "4.0 s", "6.0 s"]
    colours = [view.style.trajectory_colour for view in scene.trails]
    assert len(set(colours)) == len(colours) == 60
    along = np.concatenate([view.points[:, 0] for view in scene.trails])
    assert (along[0], along[-1]) == pytest.approx((1.0, 9.0))
    faint = [view.style.alpha for view in scene.ghosts if view.name != "robot_0"]
    assert max(faint) < 0.2


def test_the_picture_of_a_strobe(crossed: tuple[World, Recording], tmp_path: Path) -> None:
    world, recording = crossed
    layout = lay_out(world.model.bounds)
    picture = draw_strobe(recording, layout, count=5)

    def colour(x: float, y: float) -> list[int]:
        column, row = layout.column_row(x, y)
        return picture[round(row), round(column)].astype(int).tolist()

    red, green, blue = colour(3.15, 5.15)  # within a ghost: a light green
    assert green > max(red, blue)
    assert colour(2.35, 5.15) == [255, 255, 255]  # between two of them
    assert min(colour(2.0, 5.0)) < 100  # on the way, early: dark violet
    assert colour(9.1, 5.2)[:1] == [0]  # the robot itself
    assert save_strobe(recording, tmp_path / "way.svg", layout, count=5).read_text().count("4.0 s") == 1


def test_a_body_that_waits_has_one_time(crossed: tuple[World, Recording]) -> None:
    world, _ = crossed
    renderer, recording = world.renderer(), Recording(world.scenario, ["robot_0"])
    for k in range(41):
        world.move(0, 1.0 + 0.2 * max(k - 20, 0), 5.0)
        world.state.time[0] = 0.1 * k
        recording.note(renderer.scene(0, ""), world.state.pose[0], [{}])
    texts = [label.text for label in strobe(recording, lay_out(world.model.bounds), count=5).labels]
    assert texts == ["0.0\N{EN DASH}2.0 s", "3.0 s"]


def test_a_strobe_without_agents_has_faint_outlines_alone(crossed: tuple[World, Recording]) -> None:
    world, _ = crossed
    renderer, recording = world.renderer(), Recording(world.scenario)
    for k in range(5):
        world.move(1, 2.0 + k, 2.0)
        recording.note(renderer.scene(0, ""), world.state.pose[0])
        world.step()
    scene = strobe(recording, lay_out(world.model.bounds), count=5)
    stood = [view.anchor[0] for view in scene.ghosts if view.name != "robot_0"]
    assert stood == pytest.approx([2.0, 3.0, 4.0, 5.0])
    assert all(view.style.alpha == pytest.approx(0.12) for view in scene.ghosts)
    assert (scene.trails, scene.labels) == ((), ())
