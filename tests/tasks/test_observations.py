"""Every observation against values worked out by hand, and within its bounds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely
from shapely import affinity, geometry
from task_tools import BALL, ROBOT, drive, play

from irsim_gym.simulator.world.group import records
from irsim_gym.tasks.observations.scan.ranges import RangeCode
from irsim_gym.tasks.observations.scan.scan import Scan, Sectors, encode, pool, sector_beams
from irsim_gym.tasks.terms.episode_state import EpisodeState
from irsim_gym.tasks.terms.term import Bound


def part(episodes: Any, name: str) -> Any:
    """Return one part of the observation of the first agent of the first world."""
    column = 0
    for term, low, _ in episodes.observation_terms:
        if term == name:
            return episodes.view.observation[0, 0, column : column + len(low)]
        column += len(low)
    raise KeyError(name)


def only(*observations: Any) -> dict[str, Any]:
    """Return a task with these observations alone and no goal."""
    return {"name": "blank", "observations": list(observations)}


def inverse(depth: float) -> float:
    return (1 / (depth + 0.5) - 0.3) / 1.7


# --- sectors


@pytest.mark.parametrize("span", [2 * np.pi, np.pi, 1.0])
def test_sectors_of_an_even_fan_have_equal_shares(span: float) -> None:
    first, last = sector_beams(np.linspace(-span / 2, span / 2, 180), 36)
    assert (last - first).tolist() == [5] * 36
    assert first.tolist() == list(range(0, 180, 5))


@pytest.mark.parametrize(("beams", "sectors"), [(180, 36), (180, 60), (100, 36), (37, 36), (36, 36), (7, 3), (2, 2)])
def test_sectors_share_out_every_beam_once_and_mirror(beams: int, sectors: int) -> None:
    first, last = sector_beams(np.linspace(-2.0, 2.0, beams), sectors)
    assert first[0] == 0
    assert last[-1] == beams
    assert (first[1:] == last[:-1]).all()
    sizes = last - first
    assert sizes.min() >= 1
    assert sizes.max() - sizes.min() <= 1


def test_fewer_beams_than_sectors_give_as_many_sectors_as_beams() -> None:
    first, last = sector_beams(np.linspace(-1.0, 1.0, 7), 36)
    assert first.tolist() == list(range(7))
    assert last.tolist() == list(range(1, 8))
    assert [part.tolist() for part in sector_beams(np.zeros(1), 36)] == [[0], [1]]


def test_beams_that_all_point_the_same_way_are_the_first_sectors() -> None:
    first, last = sector_beams(np.zeros(4), 3)
    assert (first[0], last[0]) == (0, 4)
    assert (last > first).all()


@pytest.mark.parametrize(("number", "angle_range"), [(1, 0.0), (1, 3.0), (5, 0.0)])
def test_a_scanner_that_looks_one_way_only(number: int, angle_range: float) -> None:
    """The ball begins 2.3 m ahead of the robot's outline; NumPy warns of nothing, as warnings are errors here."""
    sensor = {"name": "lidar2d", "number": number, "angle_range": angle_range, "range_max": 6}
    task = {"name": "blank", "observations": [{"name": "scan", "code": "linear"}]}
    seen = play(robot={"sensors": [sensor]}, obstacle=BALL, task=task).view.observation[0, 0]
    np.testing.assert_allclose(seen, 1 - 2.3 / 6, atol=1e-6)


def test_sectors_go_by_angle_not_by_number() -> None:
    # Three beams crowd to the right, one points left: two sectors of half the angle each.
    first, last = sector_beams(np.array([-1.0, -0.9, -0.8, 1.0]), 2)
    assert first.tolist() == [0, 3]
    assert last.tolist() == [3, 4]
    # A sector without a beam takes the nearest one.
    first, last = sector_beams(np.array([-1.0, -0.9, -0.8, 1.0]), 3)
    assert [list(range(i, j)) for i, j in zip(first, last, strict=True)] == [[0, 1, 2], [2], [3]]


def test_pool_takes_the_least_depth_beyond_the_own_outline() -> None:
    ranges = np.array([[[1.0, 0.9, 3.0, 6.0]]], np.float32)
    extent = np.array([[0.2, 0.5, 0.25, 0.0]], np.float32)
    first, last = np.array([0, 2], np.uint64), np.array([2, 4], np.uint64)
    out = pooled(ranges, first, last, extent, 1, column=1)
    assert out == pytest.approx([1 - 0.4 / 6, 1 - 2.75 / 6])


def pooled(ranges: np.ndarray, first: np.ndarray, last: np.ndarray, extent: np.ndarray, code: int, column: int = 0):
    """Return what a scan of one agent is pooled to, its greatest range 6 m."""
    sectors = Sectors(ranges, np.zeros(1, np.int64), first, last, extent, np.array([6.0], np.float32), first, first)
    options = records([Scan(code=("inverse", "linear")[code], near=0.5, zero=0.3)])
    width = column + len(first)
    sizes = dict.fromkeys(("world", "agent", "action", "ending", "reward", "extra"), 1)
    episode = EpisodeState.allocate({**sizes, "feature": width})
    pool(np.arange(1), Bound(np.zeros(1, np.int64), column, options), sectors, episode)
    assert not episode.observation[..., :column].any()
    return episode.observation[0, 0, column:]


@pytest.mark.parametrize("code", [0, 1])
def test_sectors_of_one_beam(code: int) -> None:
    ranges = np.array([[[0.1, 2.0, 6.0, 0.5, 4.0]]], np.float32)
    extent, first = np.array([[0.2, 0.5, 0.0, 0.5, 0.1]], np.float32), np.arange(5, dtype=np.uint64)
    out = pooled(ranges, first, first + np.uint64(1), extent, code)
    depths = np.array([0.0, 1.5, 6.0, 0.0, 3.9])
    assert out == pytest.approx(inverse(depths) if code == 0 else 1 - depths / 6, abs=1e-6)


@pytest.mark.parametrize("code", [0, 1])
def test_codes_fall_with_the_depth(code: int) -> None:
    depths = np.sort(np.random.default_rng(0).uniform(0, 6, 5000)).astype(np.float32)
    codes = depths.copy()
    encode(codes, RangeCode(code, np.float32(0.5), np.float32(0.3), np.float32(6.0)))
    assert (np.diff(codes) <= 0).all()
    assert codes == pytest.approx(inverse(depths) if code == 0 else 1 - depths / 6, abs=1e-6)


def test_scan_of_a_ball_ahead() -> None:
    # The ball's surface is 2 m ahead, 1.8 m beyond the robot's own; nothing else is in range.
    episodes = play({"state": [2.5, 5, 0]}, BALL)
    scan = part(episodes, "scan")
    assert len(scan) == 36
    assert scan[17] == pytest.approx(inverse(1.8), abs=2e-3)  # the beam nearest to straight ahead points 1 degree off
    assert scan[18] == pytest.approx(inverse(1.8), abs=2e-3)
    assert scan[[0, 9, 27, 35]] == pytest.approx([inverse(5.8)] * 4, abs=1e-6)
    drive(episodes, -1, 0)
    assert part(episodes, "scan") == pytest.approx(scan)


def test_scan_bounds_are_tight() -> None:
    episodes = play({"state": [4.3, 5, 0]}, BALL, only("scan"))
    (_, low, high), scan = episodes.observation_terms[0], part(episodes, "scan")
    assert high == pytest.approx(np.ones(36))
    assert low == pytest.approx(np.full(36, inverse(5.8)), abs=1e-6)
    assert scan[17:19] == pytest.approx(high[17:19], abs=5e-3)
    assert (scan[[0, 35]] == low[[0, 35]]).all()
    assert (scan <= high).all()


@pytest.mark.parametrize(
    ("observation", "low"),
    [
        ("goal", [0, -1, -1, 0]),
        ("last_action", [-1, -1]),
        ({"name": "nearest_bodies", "count": 2, "code": "linear"}, [-1, -1, 0, -1, -1] * 2),
        ("route", [-1, -1, 0]),
        ({"name": "neighbors", "count": 2}, [-1, -1, -1, -1, 0, 0] * 2),
    ],
)
def test_bounds_of_what_has_a_sign_and_of_what_has_none(observation: Any, low: list[float]) -> None:
    episodes = play(task=only(observation))
    (_, least, greatest), *others = episodes.observation_terms
    assert not others
    assert least.tolist() == low
    assert greatest.tolist() == [1.0] * len(low)
    assert (least.dtype, greatest.dtype) == (np.float32, np.float32)


def test_scan_linear_and_narrow() -> None:
    sensor = {"name": "lidar2d", "number": 5, "angle_range": 1.0, "range_max": 4}
    episodes = play({"state": [2.5, 5, 0], "sensors": [sensor]}, BALL, only({"name": "scan", "code": "linear"}))
    scan = part(episodes, "scan")
    assert len(scan) == 5
    assert scan[2] == pytest.approx(1 - 1.8 / 4, abs=1e-6)
    assert scan[[0, 4]] == pytest.approx([0.2 / 4] * 2, abs=1e-6)


def test_scan_subtracts_the_outline_of_a_box() -> None:
    # The sensor sits in the middle of a 1.0 x 0.4 m box: 0.5 m to its front, 0.2 m to its side.
    shape = {"name": "rectangle", "length": 1.0, "width": 0.4}
    sensor = {"name": "lidar2d", "number": 3, "angle_range": np.pi, "range_max": 4}
    ball = {**BALL, "state": [5, 8, 0]}
    episodes = play({"shape": shape, "state": [5, 5, 0], "sensors": [sensor]}, ball, only({"name": "scan"}))
    assert part(episodes, "scan") == pytest.approx([inverse(3.8), inverse(3.5), inverse(2.3)], abs=1e-5)


def test_near_and_zero_must_fit() -> None:
    assert list(Scan(near=0.5, zero=1.0).problems()) == []
    assert list(Scan(near=0.5, zero=1.1).problems()) == [("zero", "must be <= 0.5 / near = 1, got 1.1")]


# --- goal, goal_heading, last_action, velocity


@pytest.mark.parametrize(
    ("pose", "goal", "expected"),
    [
        ([2, 5, 0], [8, 5], (6 / np.sqrt(200), 1, 0, np.exp(-6))),
        ([2, 5, np.pi / 2], [8, 5], (6 / np.sqrt(200), 0, -1, np.exp(-6))),
        ([2, 5, np.pi], [2, 2], (3 / np.sqrt(200), 0, 1, np.exp(-3))),
        ([2, 5, 1.0], [2, 5], (0, 1, 0, 1)),
        ([0, 0, 0], [40, 30], (1, 0.8, 0.6, 0)),
    ],
)
def test_goal(pose: list[float], goal: list[float], expected: tuple[float, ...]) -> None:
    assert part(play({"state": pose, "goal": goal}), "goal") == pytest.approx(expected, abs=1e-6)


def test_goal_with_a_scale_of_its_own() -> None:
    episodes = play({"goal": [8, 5]}, task={"observations": [{"name": "goal", "scale": 12, "near": 3}]})
    assert part(episodes, "goal") == pytest.approx([0.5, 1, 0, np.exp(-2)], abs=1e-6)


def test_goal_heading() -> None:
    task = {"observations": ["goal_heading"]}
    episodes = play({"state": [2, 5, 0.5], "goal": [8, 5, 1.5], "arrive_mode": "state"}, task=task)
    assert part(episodes, "goal_heading") == pytest.approx([np.cos(1), np.sin(1)], abs=1e-6)
    assert part(play({"goal": [8, 5]}, task=task), "goal_heading").tolist() == [0, 0]


def test_last_action_is_the_cut_action() -> None:
    episodes = play()
    assert part(episodes, "last_action").tolist() == [-1, 0]
    drive(episodes, 0.25, 3)
    assert part(episodes, "last_action").tolist() == [0.25, 1]


def test_velocity_is_what_was_executed() -> None:
    task = {"observations": ["velocity"]}
    episodes = play({"acce": [2, 3], "vel_min": [-0.5, -1.5]}, task=task)
    assert part(episodes, "velocity").tolist() == [0, 0]
    drive(episodes, 1, 1)  # 0.2 m/s of 1 m/s and 0.3 rad/s of 1.5 rad/s after one step
    assert part(episodes, "velocity") == pytest.approx([0.2, 0.2])
    (_, low, high) = episodes.observation_terms[-1]
    assert low.tolist() == [-0.5, -1]
    assert high.tolist() == [1, 1]


@pytest.mark.parametrize(
    ("speeds", "least", "low"),
    [
        # At most 0.3 m/s, a robot that may back with 0.5 m/s backs with 0.3: all of its speed. With 0.9, 0.5 of 0.9.
        ([0.3, 0.9], -0.5, -1.0),
        ([0.8, 2.0], -0.4, -0.5),
        ([0.0, 2.0], -0.4, -1.0),
        ([0.5, 2.0], 0.0, 0.0),
        ([0.5, 2.0], 0.2, 0.0),
        ([0.0, 0.0], -0.4, 0.0),
    ],
)
def test_velocities_stay_in_bounds_that_hold_for_every_drawn_speed(
    speeds: list[float], least: float, low: float
) -> None:
    robot = {"speed_range": speeds, "vel_min": [least, -1.5]}
    episodes = play(robot, task=only("velocity"), n_worlds=40)
    ((_, lows, highs),) = episodes.observation_terms
    assert lows.tolist() == [low, -1.0]
    assert highs.tolist() == [float(speeds[1] > 0.0), 1.0]
    for ahead in (1.0, -1.0):
        drive(episodes, ahead, 1.0)
        seen = episodes.view.observation[:, 0]
        assert ((seen >= lows) & (seen <= highs)).all()


# --- nearest_bodies


NOBODY = [0, 0, (1 / 10.5 - 0.3) / 1.7, 0, 0]
"""What is read for a body that is not there; it sees 10 m far."""


def nearest(robot: Any, obstacle: Any, **options: Any) -> Any:
    episodes = play(robot, obstacle, only({"name": "nearest_bodies", "count": 3, "range": 10, **options}))
    return episodes, part(episodes, "nearest_bodies").reshape(-1, 5)


def test_nearest_bodies_in_the_agents_frame() -> None:
    balls = [
        {"shape": {"name": "circle", "radius": 1.0}, "state": [2, 9, 0]},
        {"shape": {"name": "circle", "radius": 0.5}, "state": [4, 5, 0]},
    ]
    _, rows = nearest({"state": [2, 5, np.pi / 2]}, balls)  # its radius is 0.2
    assert rows[0] == pytest.approx([0, -1, inverse(1.3), 0, 0], abs=1e-6)
    assert rows[1] == pytest.approx([1, 0, inverse(2.8), 0, 0], abs=1e-6)
    assert rows[2] == pytest.approx(NOBODY)


def test_nearest_bodies_shows_the_nearest_point_of_walls_and_boxes() -> None:
    wall = {"shape": {"name": "linestring", "vertices": [[0, 0], [10, 0]]}}
    box = {"shape": {"name": "rectangle", "length": 2, "width": 2}, "state": [5, 5, np.pi / 2]}
    _, rows = nearest({"state": [2, 5.5, 0]}, [wall, box])
    assert rows[0] == pytest.approx([1, 0, inverse(1.8), 0, 0], abs=1e-6)
    assert rows[1] == pytest.approx([0, -1, inverse(5.3), 0, 0], abs=1e-6)


@pytest.mark.parametrize(("ball", "gap"), [([2, 9], 4 - 0.5 - 0.3), ([8, 5], 6 - 0.5 - 1.5), ([2, 1], 4 - 0.5 - 0.3)])
def test_nearest_bodies_are_as_far_as_the_agents_own_outline(ball: list[float], gap: float) -> None:
    """A box of 2 m x 0.6 m whose origin is 0.5 m from its rear, looking along x."""
    box = {"name": "polygon", "vertices": [[-0.5, -0.3], [1.5, -0.3], [1.5, 0.3], [-0.5, 0.3]]}
    sphere = {"shape": {"name": "circle", "radius": 0.5}, "state": [*ball, 0]}
    _, rows = nearest({"state": [2, 5, 0], "shape": box}, sphere)
    assert rows[0, 2] == pytest.approx(inverse(gap), abs=1e-6)


def test_nearest_bodies_code_is_that_of_the_scan() -> None:
    ball = {"shape": {"name": "circle", "radius": 1.0}, "state": [6.2, 5, 0]}
    _, rows = nearest({"state": [2, 5, 0]}, ball, code="linear")
    assert rows[:, 2] == pytest.approx([1 - 3.0 / 10, 0, 0])
    _, rows = nearest({"state": [2, 5, 0]}, ball, near=0.25, zero=0.0)
    assert rows[0, 2] == pytest.approx(0.25 / 3.25)
    _, rows = nearest([ROBOT, {**ROBOT, "state": [2.3, 5, 0]}], None)
    assert rows[0] == pytest.approx([1, 0, 1, 0, 0])  # in contact, 0.1 m deep


def test_nearest_bodies_move_relative_to_the_agent() -> None:
    mover = {**ROBOT, "name": "mover", "state": [5, 5, np.pi], "goal": [0, 5, 0], "behavior": {"name": "dash"}}
    robots = [{**ROBOT, "state": [2, 5, 0]}, mover]
    episodes, _ = nearest(robots, None)
    drive(episodes, 0, 0)  # 0.5 m/s towards each other's 1 m/s
    rows = part(episodes, "nearest_bodies").reshape(-1, 5)
    assert rows[0] == pytest.approx([1, 0, inverse(4.9 - 2.05 - 0.4), -0.75, 0], abs=1e-6)


def test_nearest_bodies_shows_the_nearest_cell_of_a_map() -> None:
    # 5 x 5 cells of 2 m; the one at x 4 to 6, y 6 to 8 is occupied. The robot looks up from (3, 4).
    cells = np.zeros((5, 5), np.bool_)
    cells[2, 3] = True
    task = only({"name": "nearest_bodies", "count": 3, "range": 10})
    episodes = play({"state": [3, 4, np.pi / 2]}, BALL | {"state": [3, 9, 0]}, task, obstacle_map=cells)
    rows = part(episodes, "nearest_bodies").reshape(-1, 5)
    far = 5**0.5
    assert rows[0].tolist() == pytest.approx([2 / far, -1 / far, inverse(far - 0.2), 0, 0], abs=1e-6)
    assert rows[1, :2] == pytest.approx([1, 0])
    assert rows[2] == pytest.approx(NOBODY)


def test_nearest_bodies_keeps_the_nearest_in_order() -> None:
    places = [[9, 9, 0], [2, 6, 0], [7, 5, 0], [2, 2, 0], [4, 5, 0]]
    balls = [{"shape": {"name": "circle", "radius": 0.1}, "state": place} for place in places]
    _, rows = nearest({"state": [2, 5, 0]}, balls)
    assert rows[:, :3] == pytest.approx(
        np.array([[0, 1, inverse(0.7)], [1, 0, inverse(1.7)], [0, -1, inverse(2.7)]]), abs=1e-5
    )
    _, rows = nearest({"state": [2, 5, 0]}, balls, range=1.5)
    assert rows[:, :2].tolist() == [[0, 1], [0, 0], [0, 0]]


# --- exact_free_travel


def ways(robot: Any, obstacle: Any, *, n: int = 8, **world: Any) -> Any:
    """Return how far a robot may go in each direction [m], the first one straight behind."""
    options = {"directions": n, "horizon": 4.0, "code": "linear"}
    episodes = play(robot, obstacle, only({"name": "exact_free_travel", **options}), **world)
    return 4.0 * (1.0 - part(episodes, "exact_free_travel"))


def test_exact_free_travel_ends_where_discs_touch() -> None:
    """The ball lies 3 m ahead and 0.4 m to the left; their radii are 0.2 m and 0.5 m."""
    ball = {"shape": {"name": "circle", "radius": 0.5}, "state": [1.6, 8, 0]}
    found = ways({"state": [2, 5, np.pi / 2], "sensors": []}, ball)
    assert found == pytest.approx([4, 4, 4, 4, 3 - (0.7**2 - 0.4**2) ** 0.5, 4, 4, 4], abs=1e-5)


def test_exact_free_travel_ends_at_sides_and_at_ends_of_walls() -> None:
    """A wall 2 m ahead that ends 0.1 m to the right: its side straight ahead, its end for a disc beside it."""
    wall = {"shape": {"name": "linestring", "vertices": [[4, 4.9], [4, 9]]}}
    found = ways({"state": [2, 5, 0], "sensors": []}, wall)
    slanted = (2 - 0.2) * 2**0.5  # at 45 degrees to the left
    assert found == pytest.approx([4, 4, 4, 4, 1.8, slanted, 4, 4], abs=1e-5)
    passing = ways({"state": [2, 4.75, 0], "sensors": []}, wall)  # 0.15 m past the end: its corner is in the way
    assert passing[4] == pytest.approx(2 - (0.2**2 - 0.15**2) ** 0.5, abs=1e-5)
    assert ways({"state": [2, 4.65, 0], "sensors": []}, wall)[4] == pytest.approx(4)


def test_exact_free_travel_leaves_what_it_touches() -> None:
    wall = {"shape": {"name": "linestring", "vertices": [[2.2001, 0], [2.2001, 10]]}}
    found = ways({"state": [2, 5, 0], "sensors": []}, wall)
    assert found == pytest.approx([4, 4, 4, 0, 0, 0, 4, 4], abs=1e-3)


def test_exact_free_travel_ignores_what_nobody_touches() -> None:
    mark = {"shape": {"name": "circle", "radius": 0.5}, "state": [4, 5, 0], "unobstructed": True}
    assert ways({"state": [2, 5, 0], "sensors": []}, mark) == pytest.approx([4] * 8)


def test_exact_free_travel_ends_at_a_map() -> None:
    # 50 x 50 cells of 0.2 m; a wall at x 4 to 4.2 below y = 5.
    cells = np.zeros((50, 50), np.bool_)
    cells[20, :25] = True
    found = ways({"state": [2, 4.5, 0], "sensors": []}, None, obstacle_map=cells)
    assert found[4] == pytest.approx(1.8, abs=0.015)
    assert found[[0, 1, 2, 6, 7]] == pytest.approx([4] * 5)
    assert found[5] == pytest.approx(4)  # it passes the corner at 45 degrees, 1.06 m from it
    assert found[3] == pytest.approx(1.8 * 2**0.5, abs=0.03)


def test_exact_free_travel_agrees_with_that_of_a_fine_scan() -> None:
    lidar = [{"name": "lidar2d", "number": 3600, "angle_range": 2 * np.pi, "range_max": 8}]
    box = {"number": 8, "shape": {"name": "rectangle", "length": 1.2, "width": 0.5}, "distribution": {"name": "random"}}
    options = {"directions": 32, "horizon": 4.0, "code": "linear"}
    both = only({"name": "free_travel", **options}, {"name": "exact_free_travel", **options})
    episodes = play({"sensors": lidar, "distribution": {"name": "random"}}, box, both, n_worlds=8)
    measured, exact = (episodes.view.observation[:, 0, i : i + 32] for i in (0, 32))
    assert np.ptp(exact) > 0.5
    assert (np.abs(measured - exact) < 0.01).mean() > 0.98  # a scan may miss the corner that is just touched


# --- time_to_collision


def times(robot: Any, obstacle: Any, *, n: int = 8, **options: Any) -> Any:
    """Return when a robot of 1 m/s would hit something for each velocity [s], the first one straight behind."""
    task = only({"name": "time_to_collision", "directions": n, "horizon": 4.0, **options})
    episodes = play({"sensors": [], **robot}, obstacle, task)
    return 4.0 * (1.0 - part(episodes, "time_to_collision"))


def test_time_to_collision_of_what_stands_is_the_way_over_the_speed() -> None:
    """The ball lies 3 m ahead and 0.4 m to the left; their radii are 0.2 m and 0.5 m."""
    ball = {"shape": {"name": "circle", "radius": 0.5}, "state": [1.6, 8, 0]}
    way = 3 - (0.7**2 - 0.4**2) ** 0.5
    facing: dict[str, Any] = {"state": [2, 5, np.pi / 2]}
    assert times(facing, ball) == pytest.approx([4, 4, 4, 4, way, 4, 4, 4], abs=1e-5)
    halves = times(facing, ball, speeds=2, speed=2.0).reshape(2, 8)  # 1 m/s, then 2 m/s
    assert halves[:, 4] == pytest.approx([way, way / 2], abs=1e-5)
    assert times(facing, ball, range=2.4).tolist() == [4] * 8  # its surface is 2.53 m away


def walker(x: float, y: float, to_x: float, to_y: float, speed: float) -> dict[str, Any]:
    """Return a disc of 0.3 m that walks to a place; it has a velocity after one step."""
    limits = {"vel_min": [-speed, -speed], "vel_max": [speed, speed]}
    shape = {"name": "circle", "radius": 0.3}
    return {
        "kinematics": {"name": "omni"}, "shape": shape, "state": [x, y, 0], "goal": [to_x, to_y, 0],
        "behavior": {"name": "dash"}, **limits,
    }  # fmt: skip


def test_time_to_collision_goes_on_with_the_velocities_of_others() -> None:
    """Somebody comes from straight ahead at 0.5 m/s; 2.95 m away after a step, 2.45 m to contact."""
    task = only({"name": "time_to_collision", "directions": 4, "horizon": 4.0})
    episodes = play({"sensors": []}, walker(5, 5, 1, 5, 0.5), task)
    drive(episodes, -1, 0)
    found = 4.0 * (1.0 - part(episodes, "time_to_collision"))
    assert found[2] == pytest.approx(2.45 / 1.5, abs=1e-5)
    assert found[[0, 1, 3]] == pytest.approx([4, 4, 4])  # whoever drives off at 1 m/s is not caught up with


def test_time_to_collision_is_in_the_frame_of_the_robot() -> None:
    """As above, for a robot that faces up and somebody who comes down."""
    task = only({"name": "time_to_collision", "directions": 4, "horizon": 4.0})
    episodes = play({"sensors": [], "state": [5, 2, np.pi / 2], "goal": [5, 8]}, walker(5, 5, 5, 1, 0.5), task)
    drive(episodes, -1, 0)
    found = 4.0 * (1.0 - part(episodes, "time_to_collision"))
    assert found[2] == pytest.approx(2.45 / 1.5, abs=1e-5)
    assert found[[0, 1, 3]] == pytest.approx([4, 4, 4])


@pytest.mark.parametrize("ends", [[[4, 5.1], [4, 9]], [[4, 9], [4, 5.1]]])
def test_time_to_collision_with_either_end_of_a_wall(ends: Any) -> None:
    """A wall ends 0.1 m beside the way: the disc of 0.2 m touches its end, not its side."""
    wall = {"shape": {"name": "linestring", "vertices": ends}}
    assert times({"state": [2, 5, 0]}, wall)[4] == pytest.approx(2 - (0.2**2 - 0.1**2) ** 0.5, abs=1e-5)


def test_time_to_collision_agrees_with_shapely_on_boxes_that_pass() -> None:
    """A box drives by; the robot's disc, moved in small steps of time, first touches it at the same time."""
    box = {
        "kinematics": {"name": "diff"}, "shape": {"name": "rectangle", "length": 1.0, "width": 0.6},
        "state": [4, 7, -1.2], "goal": [5.5, 3, 0], "behavior": {"name": "dash"},
        "vel_min": [0, -1], "vel_max": [0.8, 1],
    }  # fmt: skip
    task = only({"name": "time_to_collision", "directions": 32, "horizon": 4.0})
    episodes = play({"sensors": []}, box, task)
    drive(episodes, -1, 0)
    state, found = episodes.simulation.state, 4.0 * (1.0 - part(episodes, "time_to_collision"))
    x, y, turn = state.pose[0, 1]
    outline = affinity.translate(
        affinity.rotate(geometry.box(-0.5, -0.3, 0.5, 0.3), turn, (0, 0), use_radians=True), x, y
    )
    moments = np.arange(0.0, 4.0, 0.002)
    for k in range(32):
        angle = 2 * np.pi * k / 32 - np.pi + state.pose[0, 0, 2]
        relative = np.array([np.cos(angle), np.sin(angle)]) - state.twist[0, 1, :2]
        places = shapely.points(state.pose[0, 0, :2] + moments[:, None] * relative)
        hits = np.flatnonzero(shapely.distance(places, outline) <= 0.2)
        assert found[k] == pytest.approx(moments[hits[0]] if len(hits) else 4.0, abs=0.003)
    assert (found < 4.0).sum() >= 3


def test_time_to_collision_of_what_is_touched_is_zero_towards_it_only() -> None:
    wall = {"shape": {"name": "linestring", "vertices": [[2.2001, 0], [2.2001, 10]]}}
    assert times({"state": [2, 5, 0]}, wall) == pytest.approx([4, 4, 4, 0, 0, 0, 4, 4], abs=1e-3)
    mark = {"shape": {"name": "circle", "radius": 0.5}, "state": [4, 5, 0], "unobstructed": True}
    assert times({"state": [2, 5, 0]}, mark).tolist() == [4] * 8


# --- route


def route(robot: Any, obstacle: Any, **world: Any) -> Any:
    episodes = play({"sensors": [], **robot}, obstacle, {"name": "blank", "observations": ["route"]}, **world)
    return part(episodes, "route")


def test_route_is_the_straight_way_where_nothing_is_in_it() -> None:
    found = route({"state": [2, 2, np.pi / 2], "goal": [8, 2, 0]}, None)
    assert found[:2] == pytest.approx([0, -1], abs=0.1)
    assert found[2] == pytest.approx(6 / 200**0.5, abs=0.02)


@pytest.mark.parametrize("kind", ["wall", "map"])
def test_route_leads_around_what_stands(kind: str) -> None:
    """A wall from (5, 0) to (5, 8): the shortest way goes over its upper end, 0.2 m off."""
    cells = np.zeros((50, 50), np.bool_)
    cells[25, :40] = True
    wall = {"shape": {"name": "linestring", "vertices": [[5, 0], [5, 8]]}}
    given = {"obstacle": wall} if kind == "wall" else {"obstacle": None, "obstacle_map": cells}
    found = route({"state": [4, 2, 0], "goal": [6.2, 2, 0]}, **given)
    assert found[1] > np.cos(np.radians(27))  # up along the wall, as exactly as a step to 16 neighbours can tell
    assert found[2] == pytest.approx(1.0, abs=0.1)  # some 12.5 m, over 14.1 m


def test_route_without_a_way_is_straight() -> None:
    ring = {"shape": {"name": "circle", "radius": 1.0}, "state": [8, 5, 0]}  # the goal lies in it
    assert route({"state": [2, 5, 0], "goal": [8, 5, 0]}, ring) == pytest.approx([1, 0, 6 / 200**0.5])


def test_route_leads_to_the_next_goal() -> None:
    """The second goal is up; the first is reached within two steps."""
    robot = {"state": [2, 5, 0], "goal": [[[2.3, 5, 0], [2.2, 9, 0]]], "goal_threshold": 0.3, "sensors": []}
    episodes = play(robot, None, {"name": "blank", "observations": ["route"]})
    assert part(episodes, "route")[0] == pytest.approx(1)
    for _ in range(2):
        drive(episodes, 0, 0)
    assert part(episodes, "route")[1] > 0.97
    assert part(episodes, "route")[2] == pytest.approx(4 / 200**0.5, abs=0.02)


# --- the whole


@pytest.mark.parametrize(
    "observations",
    [
        ["velocity", "goal_heading", "nearest_bodies", "exact_free_travel", "time_to_collision"],
        [{"name": "scan", "code": "linear"}, "route"],
    ],
)
def test_all_observations_stay_within_their_bounds(observations: list[Any]) -> None:
    task = {"observations": observations}
    robot = {"distribution": {"name": "random"}}
    balls = {"number": 5, "shape": {"name": "circle", "radius": 0.4}, "distribution": {"name": "random"}}
    mover = {**balls, "number": 2, "kinematics": {"name": "diff"}, "behavior": {"name": "dash", "wander": True}}
    episodes = play(robot, [balls, mover], task, n_worlds=16)
    low, high = (np.concatenate([term[k] for term in episodes.observation_terms]) for k in (1, 2))
    assert (low >= -1).all()
    assert (high <= 1).all()
    rng = np.random.default_rng(3)
    for _ in range(150):
        episodes.step(rng.uniform(-1.2, 1.2, (16, 1, 2)))
        seen = episodes.view.observation
        assert seen.dtype == np.float32
        assert ((seen >= low) & (seen <= high)).all()
        episodes.begin_next(np.flatnonzero(episodes.view.terminated[:, 0]))


# --- the own body


def test_own_body_tells_size_limits_and_step() -> None:
    """Radius 0.2 m, 0.5 m/s ahead and 0.25 m/s back, 1.5 rad/s, 1 m/s2 and no limit of turning, steps of 0.1 s."""
    robot = {"vel_min": [-0.25, -1.5], "vel_max": [0.5, 1.5], "acce": [1.0, float("inf")]}
    seen = play(robot, task=only("own_body")).view.observation[0, 0]
    assert seen == pytest.approx([0.2 / 0.7, 0.5 / 1.5, 0.25 / 1.25, 1.5 / 2.5, 0.0, 0.5, 1.0, 0.5])
    omni = {"kinematics": {"name": "omni"}, "vel_min": [0, -3], "vel_max": [1, 3]}
    seen = play(omni, task=only("own_body")).view.observation[0, 0]
    assert seen[[1, 2, 3, 4]] == pytest.approx([0.5, 0.0, 0.75, 1.0])
