"""Observations that are pictures: what covers which pixels, worked out by hand or from many samples for each pixel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
import shapely
from task_tools import BALL, ROBOT, drive, play

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.errors import ScenarioError
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.observations.images.painting import LINE

# 32 pixels for 8 m: 4 pixels for each metre, the agent at 16, 16.
SMALL = {"name": "occupancy_image", "pixels": 32, "metres": 8.0}
BARE = {**SMALL, "edge": False, "goal_channel": False}


def seeing(*observations: Mapping[str, Any], pose: Any = (5, 5, 0), **more: Any) -> Episodes:
    """Return a world of 10 m with a robot that observes these."""
    robot = more.pop("robot", {**ROBOT, "state": list(pose)})
    task = {"name": "blank", "observations": list(observations)}
    return play(robot=robot, task=task, **more)


def picture(observation: Mapping[str, Any], pose: Any = (5, 5, 0), agent: int = 0, **more: Any) -> Bytes:
    """Return what a robot sees at the start."""
    return seeing(observation, pose=pose, **more).view.images[observation["name"]][0, agent]


def middle_of(channel: Bytes) -> tuple[float, float]:
    """Return the row and the column around which a channel's values lie, pixels counted by their edges."""
    weight = channel.astype(np.float64)
    rows, columns = np.indices(channel.shape) + 0.5
    return float((rows * weight).sum() / weight.sum()), float((columns * weight).sum() / weight.sum())


@pytest.mark.parametrize(
    ("heading", "rotated", "row", "column"),
    [
        (0.0, True, 8, 16),  # the disc is 2 m ahead: 8 pixels above the middle
        (np.pi / 2, True, 16, 24),  # ... to its right
        (np.pi, True, 24, 16),  # ... behind it
        (-np.pi / 2, True, 16, 8),  # ... to its left
        (2.0, False, 16, 24),  # with the y axis up, what is to the east is to the right, whatever the heading
    ],
)
def test_a_disc_covers_its_pixels(heading: float, rotated: bool, row: int, column: int) -> None:
    disc = {**BALL, "state": [7, 5, 0]}
    seen = picture({**BARE, "rotated": rotated}, (5, 5, heading), obstacle=disc)
    assert (seen.dtype, seen.shape) == (np.uint8, (32, 32, 1))
    assert middle_of(seen[..., 0]) == pytest.approx((row, column), abs=0.01)
    assert seen.sum() / 255 == pytest.approx(np.pi * 2.0**2, rel=0.01)  # a radius of 2 pixels
    assert (seen[row - 1 : row + 1, column - 1 : column + 1] == 255).all()
    seen[row - 2 : row + 2, column - 2 : column + 2] = 0
    assert not seen.any()


def test_what_covers_a_part_of_a_pixel_shows_in_part() -> None:
    # From 1 to 2 m ahead and from 0.1 m to its right to 0.025 m to its left: 4 rows, 0.4 and 0.1 of two columns.
    box = {"shape": {"name": "rectangle", "length": 1.0, "width": 0.125}, "state": [6.5, 4.9625, 0]}
    seen = picture(BARE, obstacle=box)[..., 0]
    expected = np.zeros((32, 32))
    expected[8:12, 15:17] = 255 * np.array([0.1, 0.4])
    np.testing.assert_allclose(seen, expected, atol=1)


def test_the_edge_of_the_world_and_what_is_beyond() -> None:
    # It looks west, 1 m away from the edge, which is 4 pixels above the middle.
    seen = picture({**BARE, "edge": True}, (1, 5, np.pi))[..., 0]
    assert (seen[:12] == 255).all()
    assert not seen[12:].any()
    assert not picture(BARE, (1, 5, np.pi)).any()
    # In the corner, its heading halfway between two sides: the upper half is outside but for the diagonal.
    corner = picture({**BARE, "edge": True}, (0, 0, -0.75 * np.pi))[..., 0]
    assert (corner[:15] == 255).all()
    assert middle_of(255 - corner)[1] == pytest.approx(16, abs=0.01)


def test_lines_have_a_thickness() -> None:
    wall = {"shape": {"name": "linestring", "vertices": [[7, 0], [7, 10]]}, "state": [0, 0, 0]}
    seen = picture(BARE, obstacle=wall)[..., 0]
    np.testing.assert_allclose(seen.sum(axis=0) / 255, LINE, atol=0.01)
    assert middle_of(seen)[0] == pytest.approx(8, abs=0.01)


@pytest.mark.parametrize("heading", [0.0, 0.6, 2.2])
def test_slanted_lines_are_as_thick_as_others(heading: float) -> None:
    """A line covers its length and its thickness at both ends, half of it each, times its thickness."""
    line = {"shape": {"name": "linestring", "vertices": [[5.6, 5.3], [6.7, 6.1]]}}
    seen = picture(BARE, (5, 5, heading), obstacle=line)[..., 0] / 255.0
    assert seen.sum() == pytest.approx((4 * np.hypot(1.1, 0.8) + LINE) * LINE, rel=0.02)
    middle = np.array([6.15 - 5, 5.7 - 5]) @ [[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]]
    assert middle_of(seen) == pytest.approx((16 - 4 * middle[0], 16 - 4 * middle[1]), abs=0.1)


@pytest.mark.parametrize(
    ("goal", "row", "column"),
    [
        ([7, 5, 0], 8, 16),  # 2 m ahead
        ([5, 4, 0], 16, 20),  # 1 m to the right
        ([9.9, 5, 0], 1.5, 16),  # 4.9 m ahead, beyond the border: the disc touches it
        ([9, 9, 0], 1.5, 1.5),  # in the corner
    ],
)
def test_the_goal_is_a_disc_in_the_last_channel(goal: list[float], row: float, column: float) -> None:
    seen = picture(SMALL, robot={**ROBOT, "state": [5, 5, 0], "goal": goal})
    assert seen.shape == (32, 32, 2)
    assert middle_of(seen[..., 1]) == pytest.approx((row, column), abs=0.02)
    assert seen[..., 1].sum() / 255 == pytest.approx(np.pi * 1.5**2, rel=0.02)  # 0.3 m are less than 1.5 pixels


def test_the_goals_disc_is_as_large_as_its_tolerance() -> None:
    seen = picture(SMALL, robot={**ROBOT, "state": [5, 5, 0], "goal": [7, 5, 0], "goal_threshold": 1.0})
    assert seen[..., 1].sum() / 255 == pytest.approx(np.pi * 4.0**2, rel=0.01)


def test_other_robots_and_what_is_left_out() -> None:
    robots = [{**ROBOT, "state": [5, 5, 0]}, {**ROBOT, "state": [7, 5, 0], "name": "other"}]
    scene: dict[str, Any] = {"robot": robots, "obstacle": {**BALL, "state": [5, 7, 0]}, "team": True}
    together = picture(BARE, **scene)[..., 0]
    apart = picture({**BARE, "robot_channel": True}, **scene)
    assert apart.shape == (32, 32, 2)
    assert middle_of(apart[..., 0]) == pytest.approx((16, 8), abs=0.02)
    assert middle_of(apart[..., 1]) == pytest.approx((8, 16), abs=0.02)
    np.testing.assert_array_equal(together, apart.max(axis=2))
    others = picture({**BARE, "robot_channel": True}, agent=1, **scene)[..., 1]
    assert middle_of(others) == pytest.approx((24, 16), abs=0.02)
    assert not picture({**BARE, "bodies": False}, **scene).any()


def test_what_can_be_pushed_has_its_own_channel() -> None:
    robots = [{**ROBOT, "state": [5, 5, 0]}, {**ROBOT, "state": [3, 5, 0], "name": "other"}]
    box = {**BALL, "state": [7, 5, 0], "mass": 1}
    scene: dict[str, Any] = {"robot": robots, "team": True, "collision_mode": "contact"}
    scene["obstacle"] = [{**BALL, "state": [5, 7, 0]}, box]
    apart = picture({**BARE, "movable_channel": True, "robot_channel": True}, **scene)
    for channel, middle in enumerate([(16, 8), (24, 16), (8, 16)]):  # a ball that stands, a robot behind, a ball ahead
        assert middle_of(apart[..., channel]) == pytest.approx(middle, abs=0.02)
    seen = picture({**BARE, "movable_channel": True}, **scene)
    np.testing.assert_array_equal(seen[..., 0], apart[..., :2].max(axis=2))
    np.testing.assert_array_equal(seen[..., 1], apart[..., 2])
    with pytest.raises(ScenarioError, match="collision_mode contact"):
        picture({**BARE, "movable_channel": True})


def test_a_body_that_cannot_be_touched_is_not_in_the_way() -> None:
    assert not picture(BARE, obstacle={**BALL, "state": [7, 5, 0], "unobstructed": True}).any()


def test_cells_of_a_map() -> None:
    cells = np.zeros((10, 10), int)
    cells[7, 6] = 100  # x from 7 to 8 m, y from 6 to 7 m
    world = {"obstacle_map": cells.tolist()}
    seen = picture(BARE, **world)[..., 0]
    expected = np.zeros((32, 32), np.uint8)
    expected[4:8, 8:12] = 255  # 2 to 3 m ahead, 1 to 2 m to the left
    np.testing.assert_array_equal(seen, expected)
    assert not picture({**BARE, "map": False}, **world).any()


def test_a_scan_as_a_picture() -> None:
    """A wall 2 m ahead of a lidar of 180 degrees: free before it, a line of hits, nothing known behind or beside."""
    wall = {"shape": {"name": "rectangle", "length": 1.0, "width": 2.0}, "state": [7.5, 5, 0]}
    lidar = {"name": "lidar2d", "number": 181, "angle_range": np.pi, "range_max": 3.0}
    robot = {**ROBOT, "state": [5, 5, 0], "sensors": [lidar]}
    seen = picture({**BARE, "from_scan": True}, robot=robot, obstacle=wall)[..., 0]
    assert (seen[9:15, 14:18] == 0).all()
    assert (seen[7, 13:19] == 255).all()
    assert (seen[:6, 13:19] == 127).all()
    assert (seen[18:] == 127).all()
    assert (seen[15, 6:26] == 0).all()
    assert (seen[15, [0, 1, 2, 29, 30, 31]] == 127).all()  # beyond 3 m
    rows, columns = np.indices(seen.shape) + 0.5
    far = np.hypot(rows - 16, columns - 16) > 3.0 * 4.0 + 1.5
    assert (seen[far] == 127).all()


def test_few_beams_leave_gaps() -> None:
    lidar = {"name": "lidar2d", "number": 5, "angle_range": np.pi, "range_max": 3.0}
    seen = picture({**BARE, "from_scan": True}, robot={**ROBOT, "state": [5, 5, 0], "sensors": [lidar]})[..., 0]
    assert (seen[5:8, 15:17] < 80).all()  # straight ahead, 0.1 rad wide: half of two columns
    assert seen[6, 12] == 127  # between two beams


def test_a_lidar_that_is_mounted_aside_and_turned() -> None:
    lidar = {"name": "lidar2d", "number": 91, "angle_range": np.pi / 2, "range_max": 1.5, "offset": [0, 1, np.pi / 2]}
    robot = {**ROBOT, "state": [5, 5, 0], "sensors": [lidar]}
    for rotated, heading in ((True, 0.7), (False, np.pi / 2)):
        seen = picture({**BARE, "from_scan": True, "rotated": rotated}, robot={**robot, "state": [5, 5, heading]})[
            ..., 0
        ]
        free = 127 - seen.astype(float)
        assert free.sum() / 127 == pytest.approx(np.pi / 4 * (1.5 * 4) ** 2, rel=0.03)
        # The middle of a quarter of a disc is 4 sqrt(2) / (3 pi) of the radius away from its tip, 4 pixels aside.
        assert middle_of(free) == pytest.approx((16, 12 - 6 * 4 * np.sqrt(2) / (3 * np.pi)), abs=0.1)


def test_a_scan_turns_with_the_robot() -> None:
    """The same room around a robot that faces another way gives the same picture, of which ahead is up."""
    lidar = {"name": "lidar2d", "number": 61, "angle_range": 2.0, "range_max": 3.5, "offset": [0.3, -0.4, 0.5]}
    seen = []
    for heading in (0.0, 0.83, 2.6):
        turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
        posts = [np.array([5.0, 5.0]) + turn @ place for place in ([2.2, 0.7], [1.5, -0.6])]
        scene = [{**BALL, "shape": {"name": "circle", "radius": 0.4}, "state": [*post, 0]} for post in posts]
        robot = {**ROBOT, "shape": {"name": "circle", "radius": 0.2}, "sensors": [lidar], "state": [5, 5, heading]}
        seen.append(picture({**BARE, "from_scan": True}, robot=robot, obstacle=scene)[..., 0].astype(int))
    assert (seen[0] == 255).any()
    assert (seen[0] == 0).any()
    for other in seen[1:]:
        assert np.abs(other - seen[0]).max() <= 2


SCENE: dict[str, Any] = {
    "obstacle": [
        {"shape": {"name": "circle", "radius": 0.7}, "state": [6.6, 6.1, 0]},
        {"shape": {"name": "rectangle", "length": 1.7, "width": 0.6}, "state": [3.1, 4.2, 0.4]},
        {
            "shape": {"name": "polygon", "vertices": [[0, 0], [1.4, 0.2], [0.6, 0.5], [0.3, 1.5]]},
            "state": [5.5, 2.3, 0.3],
        },
        {
            "shape": {
                "name": "compound",
                "parts": [{"name": "rectangle", "length": 1.2, "width": 0.3}, {"name": "circle", "radius": 0.4}],
            },
            "state": [2.4, 7.4, -0.5],
        },
    ]
}


@pytest.mark.parametrize(("rotated", "heading"), [(True, 0.83), (False, 0.83)])
def test_against_many_samples_for_each_pixel(rotated: bool, heading: float) -> None:
    """An oracle of its own: 12 x 12 places of each pixel, looked up in shapely's areas and beyond the world's edge."""
    pixels, metres, fine = 48, 9.0, 12
    episodes = seeing(
        {**BARE, "edge": True, "pixels": pixels, "metres": metres, "rotated": rotated},
        pose=(4.4, 4.7, heading),
        **SCENE,
    )
    seen = episodes.view.images["occupancy_image"][0, 0, ..., 0].astype(float)
    model, state = episodes.simulation.model, episodes.simulation.state
    areas = []
    for b in range(1, len(model.role)):
        first, count = model.segment_start[b], model.segment_count[0, b]
        rings = shapely.polygonize(
            [shapely.LineString(row.reshape(2, 2)) for row in state.segments[0, first : first + count]]
        )
        first, count = model.disc_start[b], model.disc_count[0, b]
        discs = [shapely.Point(x, y).buffer(radius, 90) for x, y, radius in state.discs[0, first : first + count]]
        areas += [rings, *discs]
    occupied = shapely.union(shapely.union_all(areas), shapely.box(-20, -20, 30, 30) - shapely.box(0, 0, 10, 10))
    side = (np.arange(pixels * fine) + 0.5) / (pixels * fine) - 0.5
    right, up = np.meshgrid(side * metres, -side * metres)
    turn = heading - np.pi / 2 if rotated else 0.0
    x, y = 4.4 + np.cos(turn) * right - np.sin(turn) * up, 4.7 + np.sin(turn) * right + np.cos(turn) * up
    inside = shapely.contains_xy(occupied, x, y).reshape(pixels, fine, pixels, fine)
    expected = 255.0 * inside.mean(axis=(1, 3))
    assert expected.mean() > 10
    difference = np.abs(seen - expected)
    assert difference.mean() < 0.3
    assert (difference > 11).sum() <= 4  # where the disc of the compound leaves its rectangle: shares of a pixel add up


@pytest.mark.parametrize(
    ("observation", "told"), [({**SMALL, "pixels": 4}, "pixels"), ({**SMALL, "metres": 0}, "metres")]
)
def test_bad_options_are_told(observation: Mapping[str, Any], told: str) -> None:
    with pytest.raises(ScenarioError, match=told):
        picture(observation)


def test_a_goal_and_a_sensor_are_asked_for_only_where_they_are_shown() -> None:
    plain = {key: value for key, value in ROBOT.items() if key not in ("goal", "sensors")}
    assert picture({**SMALL, "goal_channel": False}, robot=[plain]).shape == (32, 32, 1)
    with pytest.raises(ScenarioError, match="has no goal"):
        picture(SMALL, robot=[plain])
    with pytest.raises(ScenarioError, match="has no range sensor"):
        picture({**BARE, "from_scan": True}, robot=[plain])


def test_it_follows_the_robot() -> None:
    """A robot that drives ahead sees what stands there come nearer: 1 m/s for half a second are 2 pixels."""
    episodes = seeing(BARE, obstacle={**BALL, "state": [8, 5, 0]})
    before = middle_of(episodes.view.images["occupancy_image"][0, 0, ..., 0])
    for _ in range(5):
        drive(episodes, 1.0, 0.0)
    after = middle_of(episodes.view.images["occupancy_image"][0, 0, ..., 0])
    assert (after[0] - before[0], after[1] - before[1]) == pytest.approx((2.0, 0.0), abs=0.02)


def test_nothing_is_painted_that_cannot_be_seen_in_another_world() -> None:
    """Pictures of a batch are those of single worlds, whose obstacles all stand elsewhere."""
    task = {"name": "blank", "observations": [SMALL]}
    batch = Worlds("cluttered_room", 5, task=task)
    batch.begin(range(5), range(5), [{}] * 5, lambda _: 0)
    for w in range(5):
        single = Worlds("cluttered_room", 1, task=task)
        single.begin([0], [w], [{}], lambda _: 0)
        pictures = (worlds.episodes.view.images["occupancy_image"] for worlds in (batch, single))
        np.testing.assert_array_equal(*(picture[k] for picture, k in zip(pictures, (w, 0), strict=True)))
