"""A circle as in IR-SIM, and one whose starts and goals are shifted and that is turned as a whole."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

import irsim_gym as ig
from irsim_gym.errors import PlacementError, ScenarioError

N_LEVELS, RADIUS = 60, 0.2
CENTER = np.array([5.0, 5.0])


def levels(n_robots: int = 8, n_worlds: int = N_LEVELS, seed: int = 5, **scenario: Any) -> ig.Simulation:
    distribution = {"name": "circle", "radius": 4, **scenario.pop("distribution", {})}
    shape = {"name": "circle", "radius": RADIUS}
    robot = {"number": n_robots, "kinematics": {"name": "diff"}, "shape": shape, "behavior": {"name": "dash"}}
    sim = ig.compile(ig.load_scenario({"robot": {**robot, "distribution": distribution}, **scenario}), n_worlds)
    sim.reset(seed=seed)
    return sim


def nominal(n_robots: int, turned: Any = 0.0) -> np.ndarray:
    """Return places on the circle of 4 m about (5, 5), shape ``(..., n_robots, 2)``."""
    angle = np.asarray(turned)[..., None] + 2 * np.pi * np.arange(n_robots) / n_robots
    return CENTER + 4 * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def gaps(points: np.ndarray) -> np.ndarray:
    """Return the distances of all pairs, shape ``(n_worlds, n_pairs)``."""
    first, second = np.triu_indices(points.shape[1], 1)
    return np.linalg.norm(points[:, first] - points[:, second], axis=-1)


def test_without_options_all_levels_are_the_same_and_draw_nothing() -> None:
    sim = levels(4)
    assert np.all(sim.state.pose == sim.state.pose[0])
    assert sim.state.pose[0, :, :2] == pytest.approx(nominal(4))
    np.testing.assert_array_equal(sim.state.random, sim.streams(5))


def test_shifts_are_even_in_the_disc() -> None:
    sim = levels(distribution={"jitter": 0.5})
    for points, places in ((sim.state.pose, nominal(8)), (sim.state.goal, 2 * CENTER - nominal(8))):
        shift = points[..., :2] - places
        share = np.sum(shift**2, axis=-1) / 0.25  # of the disc's area: even in [0, 1], so 1/2 +- 1/sqrt(12 * 480)
        assert share.max() <= 1.0 + 1e-9
        assert share.mean() == pytest.approx(0.5, abs=4 / np.sqrt(12 * share.size))
        assert np.abs(shift.mean(axis=(0, 1))).max() < 4 * 0.25 / np.sqrt(share.size)


def test_shifted_starts_face_the_centre_and_goals_lead_on() -> None:
    sim = levels(distribution={"jitter": 0.5})
    for points, sign in ((sim.state.pose, 1.0), (sim.state.goal, -1.0)):
        offset = sign * (CENTER - points[..., :2])
        assert points[..., 2] == pytest.approx(np.arctan2(offset[..., 1], offset[..., 0]))


@pytest.mark.parametrize("jitter", [0.6, 1.0])
def test_nobody_begins_or_ends_too_near_to_another(jitter: float) -> None:
    sim = levels(16, 20, distribution={"jitter": jitter, "radius": 3.5})
    for points in (sim.state.pose, sim.state.goal):
        assert gaps(points[..., :2]).min() >= 2 * RADIUS + 0.05
    assert gaps(sim.state.pose[..., :2]).min() < 2 * RADIUS + 0.2  # 1.37 m apart without the shifts


def test_a_turn_keeps_the_circle() -> None:
    sim = levels(6, distribution={"turn": True})
    from_center = sim.state.pose[:, 0, :2] - CENTER
    turned = np.arctan2(from_center[:, 1], from_center[:, 0])
    assert sim.state.pose[..., :2] == pytest.approx(nominal(6, turned))
    assert sim.state.goal[..., :2] == pytest.approx(2 * CENTER - nominal(6, turned))
    counts, _ = np.histogram(turned, 4, (-np.pi, np.pi))
    assert counts.min() >= N_LEVELS / 4 / 3


def test_a_world_of_a_batch_is_a_single_world() -> None:
    distribution = {"jitter": 0.5, "turn": True}
    batch = levels(n_worlds=3, distribution=distribution)
    for w in range(3):
        alone = levels(n_worlds=1, seed=5 + w, distribution=distribution)
        np.testing.assert_array_equal(alone.state.pose[0], batch.state.pose[w])
        np.testing.assert_array_equal(alone.state.goal[0], batch.state.goal[w])


def test_random_obstacles_leave_room_whatever_their_place_in_the_file() -> None:
    boxes = {"number": 5, "shape": {"name": "rectangle", "length": 1, "width": 1}, "distribution": {"name": "random"}}
    sim = levels(4, 20, distribution={"jitter": 0.3, "turn": True}, obstacle=boxes)
    for w in range(20):
        rows = [sim.state.segments[w, sim.model.segment_start[b] :][:4, :2] for b in range(4, 9)]
        walls = shapely.union_all([shapely.Polygon(row) for row in rows])
        points = [*sim.state.pose[w, :4, :2], *sim.state.goal[w, :4, :2]]
        assert min(walls.distance(shapely.Point(point)) for point in points) >= RADIUS - 1e-9


def test_a_shifted_start_keeps_clear_of_a_given_wall() -> None:
    wall = {"shape": {"name": "linestring", "vertices": [[9.3, 0], [9.3, 10]]}}
    sim = levels(1, 30, distribution={"jitter": 0.5}, obstacle=wall)
    assert sim.state.pose[:, 0, 0].max() <= 9.3 - RADIUS  # up to 9.5 without the wall


def test_a_circle_too_full_names_a_body() -> None:
    with pytest.raises(PlacementError, match="no place found for 'robot_"):
        levels(12, 1, distribution={"jitter": 0.01, "radius": 0.7})


@pytest.mark.parametrize("option", [{"jitter": 0.6}, {"turn": True, "radius": 5.1}])
def test_a_circle_that_reaches_beyond_the_edge_is_refused(option: dict[str, Any]) -> None:
    with pytest.raises(ScenarioError, match=r"robot_0\.distribution: .*edge is 5 m from the centre"):
        levels(distribution={"radius": 4.5, **option})


def test_absent_members_leave_gaps() -> None:
    placed = {"name": "circle", "radius": 4, "jitter": 0.1}
    sim = levels(robot={"number_range": [1, 3], "kinematics": {"name": "diff"}, "distribution": placed})
    assert set(sim.model.present.sum(axis=1)) == {1, 2, 3}
    shift = np.linalg.norm(sim.state.pose[..., :2] - nominal(3), axis=-1)
    assert shift[sim.model.present].max() <= 0.1 + 1e-9


def test_scattered_places_are_anywhere_on_the_circle_and_mirrored_goals_opposite() -> None:
    sim = levels(6, distribution={"scatter": True, "mirror": True, "jitter": 0.3, "clearance": 0.2})
    starts, goals = sim.state.pose[:, :, :2], sim.state.goal[:, :, :2]
    assert starts + goals == pytest.approx(np.broadcast_to(2 * CENTER, starts.shape))
    away = np.linalg.norm(starts - CENTER, axis=-1)
    assert 3.7 <= away.min() < 3.75
    assert 4.25 < away.max() <= 4.3
    assert gaps(starts).min() >= 2 * RADIUS + 0.2
    angles = np.arctan2(*(starts - CENTER).T[::-1]).ravel()
    counts = np.histogram(angles, bins=6, range=(-np.pi, np.pi))[0]
    assert counts.min() > 0.6 * len(angles) / 6  # 60 in each of six parts, give or take
