"""Environments and worlds by hand of files that were written for IR-SIM: unknown keys, blocked starts, wanderers."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import irsim_gym
from irsim_gym import sb3
from irsim_gym.errors import IgnoredKeyWarning, ScenarioError, ScenarioWarning
from irsim_gym.live.world import World
from irsim_gym.tasks import Outcome

DIFF = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}}
UNKNOWN: dict[str, Any] = {"world": {"reso": 2}, "robot": {**DIFF, "state": [1, 1, 0], "goal": [9, 9]}}
WANDER: dict[str, Any] = {"name": "dash", "wander": True, "range_low": [4, 5, 0], "range_high": [5, 8, 0]}
MAKERS: dict[str, Callable[..., Any]] = {
    "make": irsim_gym.make,
    "gymnasium": lambda world, **options: gymnasium.make("irsim_gym/World-v0", scenario=world, **options),
    "make_vec": lambda world, **options: irsim_gym.make_vec(world, 2, **options),
    "parallel_env": irsim_gym.parallel_env,
    "make_batch": irsim_gym.make_batch,
    "sb3": sb3.make_vec_env,
    "teams": sb3.make_multi_agent_vec_env,
    "load": irsim_gym.load,
    "load_scenario": irsim_gym.load_scenario,
    "evaluate": lambda world, **options: irsim_gym.evaluate(world, "dash", levels=1, references=False, **options),
}


def ignored(make: Callable[[], Any]) -> tuple[Any, list[IgnoredKeyWarning]]:
    """Return what is made, and the warnings of ignored keys."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        made = make()
    return made, [one.message for one in caught if isinstance(one.message, IgnoredKeyWarning)]


@pytest.mark.parametrize("name", MAKERS)
def test_whoever_reads_a_scenario_can_be_lenient(name: str) -> None:
    with pytest.raises(ScenarioError, match=r"world.reso: unknown key"):
        MAKERS[name](UNKNOWN)
    _, (told,) = ignored(lambda: MAKERS[name](UNKNOWN, strict=False))
    assert [problem.path for problem in told.problems] == ["world.reso"]


def test_a_batch_warns_once_and_its_steps_and_resets_never() -> None:
    def play() -> None:
        batch = irsim_gym.make_batch(UNKNOWN, num_envs=4096, strict=False)
        batch.reset(seed=0)
        batch.step(np.zeros((4096, 1, 2)))

    assert len(ignored(play)[1]) == 1


def test_bodies_that_are_added_are_read_as_the_file_was() -> None:
    with pytest.raises(ScenarioError, match=r"colour: unknown key"):
        irsim_gym.load({"robot": DIFF}).add(colour="r")
    world: World = irsim_gym.load({"robot": DIFF}, strict=False)
    body, (told,) = ignored(lambda: world.add(colour="r", state=[3, 3, 0]))
    assert [problem.path for problem in told.problems] == ["obstacle.colour"]
    assert body.state[:2].tolist() == [3.0, 3.0]


def test_by_hand_a_robot_may_begin_within_an_obstacle(tmp_path: Path) -> None:
    file = tmp_path / "held.yaml"
    box = "{shape: {name: rectangle, length: 2, width: 2}, state: [1, 1, 0]}"
    file.write_text(f"robot:\n  - {{kinematics: {{name: diff}}, state: [1, 1, 0], goal: [9, 1]}}\nobstacle: {box}\n")
    with pytest.raises(
        ScenarioError, match=r"held.yaml:2   robot_0: the start lies in 'obstacle_1' \(line 3\); a robot"
    ):
        irsim_gym.make(file)
    with pytest.warns(ScenarioWarning, match=r"held.yaml:2   robot_0: the start lies in .*: the robot is stuck there"):
        world = irsim_gym.load(file)
    for _ in range(3):
        world.step([1.0, 0.0])
    # as in ir-sim 2.12.0: the flag is set by the first step, so that the robot moves once, by 1 m/s * 0.1 s
    assert world.robot.state.tolist() == pytest.approx([1.1, 1.0, 0.0])
    assert (world.robot.collided, world.status) == (True, "Collision")


def wanderer(**robot: Any) -> dict[str, Any]:
    return {"robot": {**DIFF, "state": [1, 1, 0], "behavior": WANDER, "goal_threshold": 0.5, **robot}}


def test_a_learner_that_wanders_has_the_goals_that_it_draws() -> None:
    env: Any = irsim_gym.make(wanderer())
    goals = []
    for seed in range(8):
        env.reset(seed=seed)
        goals.append(env.unwrapped.worlds.simulation.state.goal[0, 0, :2].tolist())
    x, y = np.array(goals).T
    assert ((x >= 4) & (x <= 5) & (y >= 5) & (y <= 8)).all()
    assert len(set(map(tuple, goals))) == 8
    env.reset(seed=3)
    terminated = False
    while not terminated:  # straight at the goal, which stays until it is reached
        simulation = env.unwrapped.worlds.simulation
        assert simulation.state.goal[0, 0, :2].tolist() == goals[3]
        dx, dy = simulation.state.goal[0, 0, :2] - simulation.state.pose[0, 0, :2]
        error = (np.arctan2(dy, dx) - simulation.state.pose[0, 0, 2] + np.pi) % (2 * np.pi) - np.pi
        _, _, terminated, truncated, info = env.step([float(abs(error) < 0.2), np.clip(3 * error, -1, 1)])
        assert not truncated
    assert Outcome(info["outcome"]) is Outcome.SUCCESS


def test_a_goal_that_is_given_comes_before_those_that_are_drawn() -> None:
    env: Any = irsim_gym.make(wanderer(goal=[9, 9, 0]))
    env.reset(seed=0)
    assert env.unwrapped.worlds.simulation.state.goal[0, 0, :2].tolist() == [9.0, 9.0]


def test_a_learner_that_begins_anew_draws_another_goal() -> None:
    batch = irsim_gym.make_batch(wanderer(), num_envs=2, respawn=True, max_steps=2)
    batch.reset(seed=0)
    goal = batch.worlds.simulation.state.goal
    first = goal[:, 0, :2].copy()
    for _ in range(2):
        step = batch.step(np.zeros((2, 1, 2)))
    assert step.began.all()
    assert (goal[:, 0, :2] != first).all()
    assert ((goal[:, 0, :2] >= [4, 5]) & (goal[:, 0, :2] <= [5, 8])).all()


def test_a_member_of_a_group_wanders_where_it_has_no_behavior() -> None:
    group = {**WANDER, "name": "orca"}
    base = {**DIFF, "state": [[1, 1, 0], [1, 3, 0]], "number": 2, "group_behavior": group}
    simulation = irsim_gym.compile(irsim_gym.load_scenario({"robot": base}))
    simulation.reset(seed=0)
    drawn = []
    for _ in range(400):
        goals = simulation.state.goal[0, :, :2]
        assert ((goals >= [4, 5]) & (goals <= [5, 8])).all()
        drawn += [tuple(goal) for goal in goals.tolist() if tuple(goal) not in drawn]
        simulation.step()
    assert len(drawn) > 4  # each has arrived, and drawn another goal


RANDOM: dict[str, Any] = {
    "robot": {
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "random_shape": True, "radius_range": [0.1, 0.6]},
        "distribution": {"name": "random"},
        "sensors": [{"name": "lidar2d", "number": 12, "range_max": 5}],
    },
    "obstacle": {"number": 4, "distribution": {"name": "random"}},
}


def test_a_learner_of_random_size() -> None:
    seeds, actions = range(20, 24), np.random.default_rng(0).uniform(-1, 1, (30, 2)).astype(np.float32)
    envs: Any = irsim_gym.make_vec(RANDOM, 4)
    seen = [envs.reset(seed=20)[0]]
    radii = envs.unwrapped.worlds.simulation.model.reach[:, 0].copy()
    assert len(set(radii)) == 4
    assert ((radii >= 0.1) & (radii <= 0.6)).all()
    seen += [envs.step(np.tile(action, (4, 1)))[0] for action in actions]
    for w, seed in enumerate(seeds):
        env: Any = irsim_gym.make(RANDOM)
        rows = [env.reset(seed=seed)[0]]
        for action in actions:
            observation, _, terminated, truncated, _ = env.step(action)
            assert env.observation_space.contains(observation)
            rows.append(observation)
            if terminated or truncated:
                break
        np.testing.assert_array_equal(rows, [batch[w] for batch in seen[: len(rows)]])
