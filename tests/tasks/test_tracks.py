"""tracks and time_to_tracks against what moves, which only the scans show."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from task_tools import BALL, ROBOT, drive, play

from irsim_gym.simulator.tracks.tracker import PROOFS
from irsim_gym.tasks import Episodes

STAND = (-1.0, 0.0)
ROOM = {"shape": {"name": "linestring", "vertices": [[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]]}, "state": [0, 0, 0]}
TRACKS = {"name": "tracks", "count": 3}
TOLD = {"name": "nearest_bodies", "count": 3, "moving": True}


def mover(x: float, y: float, goal: tuple[float, float], speed: float = 1.0, **more: Any) -> dict[str, Any]:
    """Return a disc of 0.2 m that dashes straight to its goal in any direction, and stays there."""
    drive = {"kinematics": {"name": "omni"}, "vel_min": [-speed, -speed], "vel_max": [speed, speed]}
    place = {"shape": {"name": "circle", "radius": 0.2}, "state": [x, y, 0], "goal": [*goal, 0]}
    return {**drive, **place, "behavior": {"name": "dash"}, **more}


def watch(
    *movers: dict[str, Any], obstacle: Any = ROOM, robot: Any = None, observations: Any = (TRACKS, TOLD), **more: Any
) -> Episodes:
    """Return episodes of a robot at (2, 5) that looks along x, among movers that pass through each other."""
    task = {"name": "blank", "max_steps": 500, "observations": list(observations), "agents": "robot_0"}
    bodies = [item for item in (obstacle if isinstance(obstacle, list) else [obstacle]) if item]
    return play(robot, [*bodies, *movers], task, collision_mode="unobstructed", **more)


def stand(episodes: Episodes, n_steps: int) -> Any:
    """Let the robot stand, and return the numbers of its tracks and those of the told bodies, ``(count, 5)`` each."""
    for _ in range(n_steps):
        drive(episodes, *STAND)
    seen = episodes.view.observation[0, 0]
    return seen[:15].reshape(3, 5), seen[15:30].reshape(3, 5)


def places(episodes: Episodes) -> Any:
    """Return x, y, vx and vy of the tracks of world 0 that are known to move, ``(n, 4)``."""
    tracks = episodes.terms["observations"][0].arrays.tracker.tracks[0, 0]
    known = tracks[tracks["used"] & (tracks["score"] >= PROOFS)]
    return np.array([[one[key] for key in ("x", "y", "vx", "vy")] for one in known]).reshape(-1, 4)


def test_a_body_that_passes_is_seen_where_it_is_and_as_fast_as_it_is() -> None:
    seen, told = stand(watch(mover(5, 8, (5, 1))), 10)
    # It has come from y = 8 m to 7 m: 3 m ahead, 2 m to the left, at 1 m/s to the right.
    away = np.hypot(3.0, 2.0)
    gap = (1.0 / (away - 0.4 + 0.5) - 0.3) / 1.7
    assert seen[0] == pytest.approx([3.0 / away, 2.0 / away, gap, 0.0, -0.5], abs=2e-3)
    assert seen == pytest.approx(told, abs=2e-3)


def test_pictures_show_a_track_and_where_it_goes() -> None:
    stand(episodes := watch(mover(5, 8, (5, 1))), 10)
    circle, arrow, key = episodes.simulation.marks(0)
    assert np.hypot(*(circle.points - [5.0, 7.0]).T) == pytest.approx(0.2, abs=5e-3)
    assert arrow.points[:2] == pytest.approx(np.array([[5.0, 7.0], [5.0, 6.0]]), abs=5e-3)
    assert key.text.startswith("seen to move")


def test_before_it_is_known_to_move_nothing_is_seen() -> None:
    seen, _ = stand(watch(mover(5, 8, (5, 1))), 1)
    far = (1.0 / (np.hypot(10.0, 10.0) + 0.5) - 0.3) / 1.7
    assert seen == pytest.approx(np.tile([0.0, 0.0, far, 0.0, 0.0], (3, 1)), abs=1e-6)


@pytest.mark.parametrize("goal", [(9.5, 5.0), (3.0, 5.0)], ids=["away", "towards"])
def test_a_body_on_the_line_of_sight_is_seen_to_move(goal: tuple[float, float]) -> None:
    seen, told = stand(watch(mover(5, 5, goal)), 8)
    assert seen == pytest.approx(told, abs=5e-3)


def test_two_people_who_cross_keep_their_velocities() -> None:
    episodes = watch(mover(5, 7, (5, 1)), mover(5.4, 3, (5.4, 9)))
    for n_steps in (10, 20, 12):
        stand(episodes, n_steps)
        found = places(episodes)
        found = found[np.argsort(found[:, 3])]
        assert found[:, 2:] == pytest.approx(np.array([[0.0, -1.0], [0.0, 1.0]]), abs=0.1)
        assert found[:, 0] == pytest.approx([5.0, 5.4], abs=0.05)


def test_who_walks_behind_another_is_followed_for_a_while() -> None:
    # The far one passes behind the near one, which stands after it has come: within 0.5 s it is seen again.
    episodes = watch(mover(3.5, 4.2, (3.5, 4.9)), mover(6, 3.0, (6, 8.0)))
    numbers = [len(places(episodes)) for _ in range(35) for _ in [drive(episodes, *STAND)]]
    assert set(numbers[8:]) == {2}
    assert places(episodes)[:, 3].max() == pytest.approx(1.0, abs=0.05)


def test_who_has_gone_behind_a_wall_is_forgotten_after_a_second() -> None:
    wall = {"shape": {"name": "rectangle", "length": 0.2, "width": 4.0}, "state": [5, 5, 0]}
    episodes = watch(mover(6.5, 9.0, (6.5, 2.0)), obstacle=[ROOM, wall])
    counts = [len(places(episodes)) for _ in range(40) for _ in [drive(episodes, *STAND)]]
    # The wall hides what is below the line from (2, 5) through (4.9, 7): y = 8.1 m at x = 6.5 m.
    assert counts[7] == 1
    assert counts[12] == 1
    assert counts[25:] == [0] * 15


def test_who_stops_is_still_seen_and_stands() -> None:
    seen, told = stand(watch(mover(5, 8, (5, 6))), 40)
    assert told[0, 3:] == pytest.approx([0.0, 0.0])
    assert seen == pytest.approx(told, abs=2e-3)


@pytest.mark.parametrize("action", [(-1.0, 1.0), (0.0, 0.7), (-0.2, -0.4)], ids=["turns", "a curve", "another"])
def test_what_stands_is_no_track_however_the_robot_drives(action: tuple[float, float]) -> None:
    box = {"shape": {"name": "rectangle", "length": 0.8, "width": 0.5}, "state": [4, 7, 0.4]}
    post = {"shape": {"name": "circle", "radius": 0.15}, "state": [3.2, 3.8, 0]}
    episodes = watch(obstacle=[ROOM, BALL, box, post])
    for _ in range(60):
        drive(episodes, *action)
        assert len(places(episodes)) == 0


def test_a_robot_that_turns_sees_the_same_body() -> None:
    episodes = watch(mover(5, 8, (5, 1)))
    for _ in range(12):
        drive(episodes, -1, 1)
    assert places(episodes) == pytest.approx(np.array([[5.0, 6.8, 0.0, -1.0]]), abs=5e-3)


def test_what_no_beam_can_see_changes_nothing() -> None:
    wall = {"shape": {"name": "rectangle", "length": 0.2, "width": 9.6}, "state": [6, 5, 0]}
    both = [watch(mover(4, 7, (4, 1)), mover(8, y, (8, 5)), obstacle=[ROOM, wall]) for y in (3.0, 8.0)]
    for _ in range(30):
        for episodes in both:
            drive(episodes, *STAND)
        one, other = (episodes.view.observation[0, 0] for episodes in both)
        assert np.array_equal(one[:15], other[:15])
    assert not np.array_equal(one[15:], other[15:])  # the true bodies differ


def test_times_to_tracks_are_those_to_the_bodies() -> None:
    times = {"directions": 24, "speeds": 2, "horizon": 8.0}
    shown = [{"name": "time_to_tracks", **times}, {"name": "time_to_collision", "moving": True, **times}]
    episodes = watch(mover(5, 8, (5, 1)), mover(4, 2.5, (4, 9), 0.7), observations=shown)
    for _ in range(10):
        drive(episodes, *STAND)
    seen = episodes.view.observation[0, 0]
    assert seen[:48] == pytest.approx(seen[48:], abs=5e-3)
    assert seen[:48].max() > 0.2


def test_observations_of_a_task_share_their_tracks() -> None:
    times = {"name": "time_to_tracks", "directions": 8}
    for other, shares in ((times, True), ({**times, "keep": 0.5}, False)):
        one, two = watch(observations=[TRACKS, other]).terms["observations"]
        assert (one.arrays.tracker is two.arrays.tracker) == shares


def test_scans_that_are_disturbed_show_disturbed_tracks() -> None:
    gaps = []
    for offset in (0.0, 0.1):
        robot = {"disturbances": [{"name": "range_bias", "offset": offset}]}
        stand(episodes := watch(mover(5, 8, (5, 1)), robot=robot), 10)
        gaps.append(float(np.hypot(*(places(episodes)[0, :2] - [2.0, 5.0]))))
    assert gaps[1] - gaps[0] == pytest.approx(0.1, abs=0.02)


def test_a_noisy_scan_makes_velocities_less_sure_and_no_ghosts() -> None:
    robot = {"sensors": [{**ROBOT["sensors"][0], "noise": True, "std": 0.02, "angle_std": 0.0}]}
    episodes = watch(mover(4, 8, (4, 1), 0.7), obstacle=[ROOM, BALL], robot=robot)
    found = []
    for _ in range(40):
        drive(episodes, *STAND)
        found.append(places(episodes))
    assert {len(each) for each in found[12:]} == {1}
    off = np.concatenate([each - [[4.0, 8.0 - 0.07 * (k + 1), 0.0, -0.7]] for k, each in enumerate(found) if k > 14])
    assert np.sqrt((off[:, :2] ** 2).mean()) < 0.04
    assert np.sqrt((off[:, 2:] ** 2).mean()) < 0.15


def test_an_episode_begins_without_the_tracks_of_the_one_before() -> None:
    episodes = watch(mover(5, 8, (5, 1)))
    first = [stand(episodes, 1)[0].copy() for _ in range(12)]
    episodes.begin(np.arange(1), np.arange(1))
    assert np.array_equal(first, [stand(episodes, 1)[0].copy() for _ in range(12)])


def test_a_robot_without_a_sensor_is_told_with_the_same_options() -> None:
    blind = {"sensors": []}
    told = [{**TRACKS, "count": 2, "speed": 1.5, "without_sensor": "nearest_bodies"}]
    (term,) = watch(mover(5, 8, (5, 1)), robot=blind, observations=told).terms["observations"]
    assert (term.name, term.options.count, term.options.speed) == ("nearest_bodies", 2, 1.5)
    assert term.options.moving
