"""What robots without a range sensor observe by ``without_sensor: nothing``, and bodies that move alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from task_tools import BALL, drive, play

RUNNER: dict[str, Any] = {
    "kinematics": {"name": "omni"}, "shape": {"name": "circle", "radius": 0.3}, "state": [4, 6, 0], "goal": [4, 1, 0],
    "behavior": {"name": "dash"}, "vel_max": [1, 1], "vel_min": [-1, -1],
}  # fmt: skip


def observe(name: str, robot: Any = None, obstacle: Any = None, **options: Any) -> Any:
    """Return the episodes, and what the first learner observes by one observation."""
    task = {"name": "blank", "observations": [{"name": name, **options}]}
    episodes = play(robot, obstacle, task)
    return episodes, episodes.view.observation[0, 0]


def blind(name: str, **options: Any) -> Any:
    """Return what a robot without a sensor observes right in front of a ball."""
    ball = {**BALL, "state": [2.8, 5, 0]}
    return observe(name, {"sensors": None}, ball, without_sensor="nothing", **options)


def test_without_a_sensor_a_scan_is_as_far_as_a_number_can_say() -> None:
    assert blind("scan")[1] == pytest.approx([-0.3 / 1.7] * 36, abs=1e-6)
    assert blind("scan", code="linear", sectors=7)[1] == pytest.approx([0.0] * 7, abs=1e-6)
    assert blind("past_scans", ago=[2], sectors=5)[1] == pytest.approx([-0.3 / 1.7] * 5, abs=1e-6)


def test_without_a_sensor_everything_within_the_horizon_is_free() -> None:
    code = (1 / (3.0 + 0.5) - 0.3) / 1.7
    assert blind("free_travel", directions=8)[1] == pytest.approx([code] * 8, abs=1e-6)


def test_without_a_sensor_the_way_is_the_straight_line() -> None:
    episodes, way = blind("way_on_seen_map")
    for _ in range(5):
        assert way == pytest.approx([1.0, 0.0, 6 / np.hypot(10, 10)], abs=1e-6)
        drive(episodes, -1.0, 0.0)


@pytest.mark.parametrize("name", ["scan", "past_scans", "free_travel", "way_on_seen_map"])
def test_without_a_sensor_observations_keep_shape_bounds_and_words(name: str) -> None:
    """The words are those of a robot whose sensor has as many beams as it has sectors."""
    seeing, seen = observe(name)
    episodes, found = blind(name)
    assert found.shape == seen.shape
    ((told, low, high),) = episodes.observation_terms
    assert told == name
    assert ((low <= found) & (found <= high)).all()
    ours, theirs = (one.terms["observations"][0] for one in (episodes, seeing))
    columns = [
        term.options.columns(term, one.simulation.model, 0) for term, one in ((ours, episodes), (theirs, seeing))
    ]
    assert [(part.meaning, part.count) for part in columns[0]] == [(part.meaning, part.count) for part in columns[1]]


@pytest.mark.parametrize("shown", [{"name": "occupancy_image", "from_scan": True}, {"name": "seen_map_image"}])
def test_without_a_sensor_pictures_do_not_show_what_stands(shown: dict[str, Any]) -> None:
    task = {"name": "blank", "observations": [{**shown, "pixels": 16, "without_sensor": "nothing"}]}
    pictures = []
    for ball in (BALL, {**BALL, "state": [2.8, 5, 0]}):
        episodes = play({"sensors": None}, ball, task)
        pictures += [image.copy() for image in episodes.view.images.values()]
    np.testing.assert_array_equal(*pictures)


def test_bodies_that_stand_and_the_map_are_left_out_of_those_that_move() -> None:
    balls = [{**BALL, "state": [3.5, 5, 0]}, RUNNER]
    for name, width in (("nearest_bodies", 5), ("time_to_collision", 32)):
        found = observe(name, None, balls, moving=True)[1]
        np.testing.assert_array_equal(found, observe(name, None, [RUNNER])[1])
        assert not np.array_equal(found, observe(name, None, balls)[1])
        alone = observe(name, None, balls[:1], moving=True)[1]
        np.testing.assert_array_equal(alone, observe(name, None)[1])
        assert len(found) % width == 0
