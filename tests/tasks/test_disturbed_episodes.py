"""Episodes of robots that do not know where they are, and disturbances of learners from outside of the file."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from task_tools import BALL, ROBOT, drive, play

import irsim_gym as ig
from irsim_gym.errors import ScenarioError
from irsim_gym.tasks import Episodes, Outcome

TASK: dict[str, Any] = {
    "name": "blank",
    "max_steps": 100,
    "observations": ["goal", "position", "scan", "nearest_bodies"],
    "rewards": [{"name": "progress", "weight": 1.0}, {"name": "arrival", "weight": 5.0}],
    "endings": ["arrived", "collided"],
}


def straight(*disturbances: dict[str, Any], **task: Any) -> Episodes:
    """Return an episode of a robot 6 m before its goal, with a ball beside its way."""
    robot = {"disturbances": list(disturbances)}
    return play(robot, {**BALL, "state": [5, 7, 0]}, {**TASK, **task})


def drive_to_the_end(episodes: Episodes) -> float:
    """Drive straight ahead until the episode ends, and return what was paid."""
    paid = 0.0
    while episodes.view.live.all():
        drive(episodes, 1, 0)
        paid += float(episodes.view.reward[0, 0])
    return paid


def test_who_believes_to_have_arrived_and_is_elsewhere_is_misplaced() -> None:
    episodes = straight({"name": "slip", "ahead": 0.1})
    paid = drive_to_the_end(episodes)
    infos = episodes.view.infos
    # It believes to be within 0.3 m after 5.8 m, in 58 steps; it has moved 5.22 m.
    assert infos["steps"][0, 0] == 58
    assert infos["outcome"][0, 0] == Outcome.MISPLACED
    assert not infos["is_success"][0, 0]
    assert episodes.view.terminated[0, 0]
    assert infos["goal_distance"][0, 0] == pytest.approx(6.0 - 5.22)
    assert infos["path_length"][0, 0] == pytest.approx(5.22)
    # Progress is that of the true pose, and the bonus is not paid.
    assert paid < 1.0


def test_who_is_nearly_where_it_believes_succeeds() -> None:
    episodes = straight({"name": "slip", "ahead": 0.04})
    assert drive_to_the_end(episodes) > 5.0
    assert episodes.view.infos["outcome"][0, 0] == Outcome.SUCCESS
    assert episodes.view.infos["goal_distance"][0, 0] == pytest.approx(6.0 - 5.8 * 0.96)


def test_a_believed_heading_counts_where_the_goal_has_one() -> None:
    outcomes = []
    for mode in ("position", "state"):
        robot = {"disturbances": [{"name": "slip", "turn": 0.9}], "goal": [2.1, 5.0, 1.0], "arrive_mode": mode}
        episodes = play(robot, None, TASK)
        while episodes.view.live.all():
            drive(episodes, 0, 1)
        outcomes.append(Outcome(episodes.view.infos["outcome"][0, 0]))
    assert outcomes == [Outcome.SUCCESS, Outcome.MISPLACED]


def test_contacts_are_those_of_the_true_pose() -> None:
    robot = {"disturbances": [{"name": "odometry", "yaw": 1.0}]}
    episodes = play(robot, BALL, TASK)
    drive_to_the_end(episodes)
    assert episodes.view.infos["outcome"][0, 0] == Outcome.COLLISION
    assert episodes.simulation.told.pose[0, 0, 2] > 1.0


def test_places_are_believed_and_what_is_measured_is_true() -> None:
    slipping, plain = straight({"name": "slip", "ahead": 0.5}), straight()
    for _ in range(20):
        drive(slipping, 1, 0)
    for _ in range(20):
        drive(plain, 1, 0)
    parts = {name: len(low) for name, low, _ in slipping.observation_terms}
    at = dict(zip(parts, np.cumsum([0, *parts.values()])[:-1].tolist(), strict=True))

    def seen(episodes: Episodes, name: str) -> np.ndarray:
        return episodes.view.observation[0, 0, at[name] : at[name] + parts[name]]

    # It believes to be 2 m on, where the other one is; truly it has moved 1 m.
    np.testing.assert_allclose(seen(slipping, "goal"), seen(plain, "goal"), atol=1e-6)
    np.testing.assert_allclose(seen(slipping, "position"), seen(plain, "position"), atol=1e-6)
    half = straight()
    for _ in range(10):
        drive(half, 1, 0)
    assert slipping.simulation.state.pose[0, 0] == pytest.approx(half.simulation.state.pose[0, 0])
    np.testing.assert_allclose(seen(slipping, "scan"), seen(half, "scan"), atol=1e-6)
    gap = slice(0, 3)  # direction and gap; the speed of its own differs
    np.testing.assert_allclose(seen(slipping, "nearest_bodies")[gap], seen(half, "nearest_bodies")[gap], atol=1e-6)


def test_a_robot_that_respawns_knows_its_pose_and_has_no_command_under_way() -> None:
    start = {"name": "random"}
    robots = [{**ROBOT, "distribution": start, "goal": [8, 8], "number": 2}]
    robots[0]["disturbances"] = [{"name": "slip", "ahead": 0.5}, {"name": "latency", "time": 0.3}]
    robots[0].pop("state")
    episodes = play(robots, None, {**TASK, "endings": ["arrived"]}, n_worlds=2, team=True)
    for _ in range(12):
        drive(episodes, 1, 0)
    sim = episodes.simulation
    other = sim.told.pose[:, 1].copy()
    assert np.all(np.any(sim.told.pose[:, :2] != sim.state.pose[:, :2], axis=-1))
    episodes.respawn(np.array([[True, False], [False, False]]))
    np.testing.assert_array_equal(sim.told.pose[0, 0], sim.state.pose[0, 0])
    np.testing.assert_array_equal(sim.told.pose[:, 1], other)
    before = sim.state.pose[:, :2].copy()
    drive(episodes, 1, 0)
    stands = np.all(sim.state.pose[:, :2] == before, axis=-1)
    assert stands.tolist() == [[True, False], [False, False]]


TEXT = "latency:time=[0, 0.3]; slip:ahead=0.1:turn=[0,0.1]; lost_beams:chance=0.2:reads=zero; odometry:fix={every: 1}"


def test_learners_alone_are_disturbed_from_outside() -> None:
    scenario = ig.load_scenario("crossing", {"disturbances": TEXT})
    assert [type(one).__name__ for one in scenario.disturbances] == ["Latency", "Slip", "LostBeams", "Odometry"]
    assert scenario.parameters["disturbances"] == TEXT
    sim = ig.compile(scenario, 1, agents=(0,))
    assert {int(b) for group in sim.parts.disturbances.groups for b in group.members} == {0}
    assert not ig.compile(scenario, 1).parts.disturbances.groups


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("latncy:time=1", "did you mean 'latency'?"),
        ("latency:time=", "disturbances[0].time: cannot be read, got ''"),
        ("latency:tim=1", "unknown key (did you mean 'time'?)"),
        ("latency", ""),
        ("slip:ahead=[0.2, 0.1]; latency:time=99", "[1].time: must lie from 0 to 10, got 99"),
        (3, "must be text such as 'latency:time=0.2; lost_beams:chance=0.1', got 3"),
    ],
)
def test_texts_are_read_or_say_what_is_wrong(text: Any, said: str) -> None:
    if not said:
        assert ig.load_scenario("corridor", {"disturbances": text}).disturbances
        return
    with pytest.raises(ScenarioError) as error:
        ig.load_scenario("corridor", {"disturbances": text})
    assert said in str(error.value)


def test_batch_single_and_threads_play_the_same_disturbed_episodes() -> None:
    envs = gymnasium.make_vec("irsim_gym/cluttered_room-v0", num_envs=5, disturbances=TEXT)
    threads = gymnasium.make_vec("irsim_gym/cluttered_room-v0", num_envs=5, num_threads=3, disturbances=TEXT)
    single = gymnasium.make("irsim_gym/cluttered_room-v0", disturbances=TEXT)
    seen, _ = envs.reset(seed=7)
    other, _ = threads.reset(seed=7)
    alone, _ = single.reset(seed=7 + 3)
    rng = np.random.default_rng(0)
    for _ in range(40):
        np.testing.assert_array_equal(seen, other)
        np.testing.assert_array_equal(seen[3], alone)
        actions = rng.uniform(-1, 1, (5, 2)).astype(np.float32)
        seen, _, ended, cut, _ = envs.step(actions)
        other, *_ = threads.step(actions)
        alone, *_ = single.step(actions[3])
        if ended[3] or cut[3]:
            break


def test_levels_stay_as_they_are() -> None:
    plain, disturbed = (
        ig.compile(ig.load_scenario("cluttered_room", given), 2, agents=(0,)) for given in ({}, {"disturbances": TEXT})
    )
    for sim in (plain, disturbed):
        sim.reset(seed=3)
    np.testing.assert_array_equal(plain.state.pose, disturbed.state.pose)
    np.testing.assert_array_equal(plain.state.goal, disturbed.state.goal)


def test_a_robot_is_larger_than_it_is_told_from_the_start_of_each_level() -> None:
    wall = {"shape": {"name": "linestring", "vertices": [[3, 0], [3, 10]]}}
    task = {**TASK, "observations": ["own_body", "goal"]}
    n, seen = 40, []
    for given in ([], [{"name": "radius", "offset": [0.1, 0.3]}]):
        episodes = play({"disturbances": given}, wall, task, n_worlds=n)
        sim = episodes.simulation
        for seed in (0, n):
            episodes.begin(np.arange(n), np.arange(n) + seed)
        seen.append(episodes.view.observation.copy())
        while episodes.view.live.any():
            drive(episodes, 1, 0)
        assert np.all(episodes.view.infos["outcome"] == Outcome.COLLISION)
        radius = sim.state.discs[:, 0, 2]
        # It stops in the first step in which it touches the wall.
        touching = 3.0 - sim.state.pose[:, 0, 0]
        assert np.all((touching <= radius) & (touching > radius - 0.1 - 1e-9))
        np.testing.assert_array_equal(np.broadcast_to(sim.model.reach[:, 0], n), radius)
    assert 0.3 <= radius.min() < 0.32 < 0.48 < radius.max() <= 0.5
    np.testing.assert_array_equal(*seen)


def test_a_radius_draws_no_number_of_the_level_and_needs_a_disc() -> None:
    starts = []
    for given in ([], [{"name": "radius", "offset": [-0.1, 0.0]}]):
        robot = {**ROBOT, "distribution": {"name": "random"}, "disturbances": given}
        robot.pop("state")
        starts.append(play([robot], None, TASK, n_worlds=8).simulation.state.pose.copy())
    np.testing.assert_array_equal(*starts)
    box = {"shape": {"name": "rectangle", "length": 1, "width": 1}, "disturbances": [{"name": "radius"}]}
    with pytest.raises(ScenarioError, match="'radius' changes a radius, but the robot has none; give it shape"):
        play(box, None, TASK)
