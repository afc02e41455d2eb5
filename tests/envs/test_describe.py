"""Environments explain themselves: every kind is described, and what is said of columns and directions is true."""

from __future__ import annotations

import inspect
import json
import math
from typing import Any

import numpy as np
import pytest
from gymnasium.spaces import Box

import irsim_gym
from irsim_gym.base.families import ACTIONS, ENDINGS, OBSERVATIONS, REWARDS
from irsim_gym.envs.described.description import Block, Description
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.tasks import Outcome
from irsim_gym.tasks.terms.words import TellsActions, TellsColumns, TellsWhen

TURN = 0.7
"""By how much the scanner is turned on the robot [rad]."""
LIDAR = {"name": "lidar2d", "number": 271, "angle_range": 4.5, "range_max": 8, "offset": [0, 0, TURN]}
DRIVE = {"kinematics": {"name": "diff"}, "vel_min": [0, -1.5], "vel_max": [1, 1.5]}
SEEN = (5.0, 5.0)
"""Where the other robot stands, the only thing to be seen [m]."""
YARD: dict[str, Any] = {
    "world": {"name": "yard", "height": 12, "width": 12, "step_time": 0.1},
    "robot": [
        {**DRIVE, "state": [1.5, 5, 0], "goal": [3, 9], "sensors": [LIDAR]},
        {**DRIVE, "state": [*SEEN, 0], "goal": [9, 9], "shape": {"name": "circle", "radius": 0.2}},
    ],
}
EVERYTHING: dict[str, Any] = {
    "agents": "robot_0",
    "observations": [
        {"name": "scan", "sectors": 27},
        {"name": "past_scans", "sectors": 30, "ago": [1, 4]},
        {"name": "free_travel", "directions": 24},
        "goal",
        "goal_heading",
        "velocity",
        "last_action",
        {"name": "pending", "steps": 2},
        "drive",
        "own_body",
        {"name": "nearest_bodies", "count": 2},
        {"name": "neighbors", "count": 2},
        {"name": "exact_free_travel", "directions": 24},
        {"name": "time_to_collision", "directions": 24},
        {"name": "tracks", "count": 2},
        {"name": "time_to_tracks", "directions": 24},
        "goal_record",
        "has_arrived",
        "route",
        "position",
        "heading",
        {"name": "trail", "sectors": 9},
        {"name": "occupancy_image", "pixels": 40, "metres": 8, "edge": False},
        {"name": "seen_map_image", "pixels": 40},
        "way_on_seen_map",
        "yielding_way",
    ],
    "endings": ["arrived", "collided", "left_world", "deadlocked"],
    "rewards": [{"name": "deadlock"}],
}


def yard(**task: Any) -> Any:
    """Return the environment in which everything is observed, without its wrappers."""
    return irsim_gym.make(YARD, task={**EVERYTHING, **task}).unwrapped


def pushed() -> Any:
    """Return an environment in which the robot pushes a box, and observes it."""
    world, box = {"collision_mode": "contact"}, {"shape": {"name": "circle"}, "state": [5, 5, 0], "mass": 1}
    task = {"name": "blank", "observations": ["movable_bodies", "contact"]}
    robot = {"kinematics": {"name": "diff"}, "state": [2, 5, 0]}
    return irsim_gym.make({"world": world, "robot": robot, "obstacle": box}, task=task).unwrapped


def test_every_shipped_kind_describes_itself() -> None:
    for family, told in ((ACTIONS, TellsActions), (OBSERVATIONS, TellsColumns), (REWARDS, TellsWhen)):
        assert [entry.name for entry in family if not issubclass(entry.kind, told)] == []
    assert [entry.name for entry in ENDINGS if not issubclass(entry.kind, TellsWhen)] == []
    description = yard().describe()
    shown = {block.name for block in (*description.blocks, *pushed().describe().blocks)}
    assert shown == {entry.name for entry in OBSERVATIONS if entry.kind.__module__.startswith("irsim_gym.")}


@pytest.mark.parametrize("form", ["flat", "dict"])
def test_columns_add_up_to_the_space(form: str) -> None:
    env = yard(observation_form=form)
    description: Description = env.describe()
    ends = dict.fromkeys(env.observation_space, 0)
    for block in description.blocks:
        space = env.observation_space[block.key]
        assert isinstance(space, Box)
        if block.is_image:
            assert (block.shape, len(block.parts)) == (space.shape, space.shape[2])
            ends[block.key] = space.shape
            continue
        for part in block.parts:
            assert part.start == ends[block.key]
            here = slice(part.start, part.stop)
            assert (part.low, part.high) == (space.low[here].min(), space.high[here].max())
            assert not part.sectors or len(part.sectors) == part.stop - part.start
            ends[block.key] = part.stop
    assert {key: np.atleast_1d(end).tolist() for key, end in ends.items()} == {
        key: list(space.shape) for key, space in env.observation_space.items()
    }


def test_directions_are_true() -> None:
    """The robot turns on the spot: the columns that answer are those that are said to look at what is there."""
    env = yard(observation_form="dict")
    description: Description = env.describe()
    env.reset(seed=0)
    for _ in range(15):
        env.step(np.array([1.0, 0.0]))
    answered = dict.fromkeys(
        ("scan", "past_scans", "free_travel", "exact_free_travel", "time_to_collision", "trail"), 0
    )
    for _ in range(45):
        observation, *_ = env.step(np.array([-1.0, 1.0]))
        x, y, heading = env.robot.pose
        away = np.array(SEEN) - (x, y)
        bearing = math.atan2(away[1], away[0]) - heading
        width = math.degrees(math.asin(0.2 / math.hypot(*away))) + 1.0
        for name, where, slack in (
            ("scan", bearing, width),
            ("past_scans", bearing, width),
            ("free_travel", bearing, 0.5 * 360 / 24),
            ("exact_free_travel", bearing, 0.5 * 360 / 24),
            ("time_to_collision", bearing, 0.5 * 360 / 24),
            ("trail", math.pi - heading, 0.1),
        ):
            answered[name] += _answers(description.block(name), observation[name], math.degrees(where), slack)
        _check_places(description, observation, away, heading)
    assert answered["past_scans"] > 45  # where the scanner does not look, nothing answers: it has a gap of 1.8 rad
    assert answered["free_travel"] > 25
    assert answered["exact_free_travel"] == answered["time_to_collision"] == 45
    assert (answered["scan"] > 25, answered["trail"]) == (True, 45)


def _answers(block: Block, row: Any, bearing: float, slack: float) -> int:
    """Return how many parts answer, after checking that the answering column looks at a bearing [degree]."""
    count = 0
    for part in block.parts:
        values = row[part.start : part.stop]
        if values.max() < 0.05:
            continue
        begin, end = part.sectors[int(values.argmax())]
        off = (bearing - 0.5 * (begin + end) + 180.0) % 360.0 - 180.0
        assert abs(off) <= 0.5 * (end - begin) + slack, (block.name, begin, end, bearing)
        count += 1
    return count


def _check_places(description: Description, observation: Any, away: Any, heading: float) -> None:
    """Check numbers that tell places: ahead and left of the robot are where they are said to be."""
    cosine, sine = math.cos(heading), math.sin(heading)
    ahead, left = away[0] * cosine + away[1] * sine, away[1] * cosine - away[0] * sine
    for name in ("nearest_bodies", "neighbors"):
        first, second = description.block(name).parts[:2]
        assert "ahead" in first.meaning
        assert "to the left" in second.meaning
        for value, told in ((observation[name][0], ahead), (observation[name][1], left)):
            assert abs(told) < 0.1 or np.sign(value) == np.sign(told)
    lit = np.argwhere(observation["occupancy_image"][..., 0] > 127) + 0.5
    row, column = lit.mean(axis=0)
    assert (20 - row, 20 - column) == pytest.approx((ahead / 0.2, left / 0.2), abs=0.6)


def test_actions_mean_what_is_said() -> None:
    env = yard(action={"name": "discrete", "linear": 2, "angular": 3})
    action = env.describe().action
    env.reset(seed=0)
    for choice, command in enumerate(action.choices):
        env.step(choice)
        assert env.robot.velocity.tolist() == pytest.approx(command)
    assert [(one.name, one.unit, one.low, one.high) for one in action.components] == [
        ("speed ahead", "m/s", 0.0, 1.0),
        ("turn rate, positive to the left", "rad/s", -1.5, 1.5),
    ]


def test_infos_rewards_and_endings() -> None:
    env = yard()
    description: Description = env.describe()
    _, info = env.reset(seed=0)
    assert {one.key.split("[")[0] for one in description.infos} == set(info)
    assert all(one.meaning not in ("", "not described") for one in description.infos)
    outcomes = next(one.meaning for one in description.infos if one.key == "outcome")
    assert all(f"{code.value} {code.name}" in outcomes for code in Outcome)
    assert {one.name: one.sign for one in description.rewards}["time"] == "-"
    assert [one.outcome for one in description.endings][-2:] == ["SUCCESS", "DEADLOCK"]  # of several the first counts


def test_infos_of_teams() -> None:
    task = {"name": "team_navigation", "action": "discrete"}
    told = irsim_gym.parallel_env("circle_swap", task=task, black_death=True).describe("robot_1").infos
    assert [one.meaning for one in told if "not described" in one.meaning] == []
    assert {"idle", "action_mask"} <= {one.key for one in told}


def test_agents_of_one_team_may_see_other_columns() -> None:
    """A robot with two components has fewer columns than one with three, in the parallel environment."""
    sideways = {"kinematics": {"name": "omni_angular"}, "vel_min": [-1, -1, -1], "vel_max": [1, 1, 1]}
    robots = [YARD["robot"][1], {**sideways, "state": [2, 2, 0], "goal": [3, 9]}]
    task = {"name": "blank", "observations": ["velocity", "goal"], "rewards": [], "endings": []}
    env = irsim_gym.parallel_env({"robot": robots}, task=task)
    for name in env.possible_agents:
        found = env.describe(name)
        assert sum(sum(block.shape) for block in found.blocks) == env.observation_space(name).shape[0]
        assert len(found.action.components) == env.action_space(name).shape[0]
    with pytest.raises(irsim_gym.errors.UnknownNameError, match="robot_1"):
        env.describe("robot_2")
    assert env.describe().same_for == ()


def test_it_is_shown_as_text_json_and_html() -> None:
    description = Worlds(YARD, task=EVERYTHING).describe()
    text, plain, page = str(description), json.loads(json.dumps(description.as_dict())), description._repr_html_()
    for block in description.blocks:
        assert block.name in text
        assert f"<td>{block.name}" in page
    assert "straight ahead: column" in text
    assert plain["blocks"][0]["parts"][0]["sectors"][0][0] == pytest.approx(math.degrees(TURN - 2.25 - 2.25 / 270))
    assert "\x1b" not in text
    assert max(map(len, text.splitlines())) <= 120


def test_on_the_command_line() -> None:
    from typer.testing import CliRunner

    from irsim_gym.cli.app import app

    result = CliRunner().invoke(app, ["describe", "empty_goal", "--task", "image_navigation"])
    assert result.exit_code == 0, result.output
    assert "0 free, 255 occupied" in result.output
    told = CliRunner().invoke(app, ["describe", "mixed_team", "--team", "--json"])
    assert next(one["agent"] for one in json.loads(told.output)) == "robot_0"


def test_what_is_printed_is_short() -> None:
    """A line with the name of the scenario, also within lists and dictionaries."""
    from irsim_gym import sb3

    env: Any = irsim_gym.make("cluttered_room")
    worlds = env.unwrapped.worlds
    simulation = worlds.simulation
    vectors = irsim_gym.make_vec("cluttered_room", num_envs=2), irsim_gym.make_batch("cluttered_room", 2)
    slots = sb3.make_vec_env("cluttered_room", 2)
    for one in (env.unwrapped, worlds, simulation, simulation.scenario, *vectors, slots):
        assert "cluttered_room" in repr([one])
        assert len(repr({"x": one})) < 100
    assert repr(vectors[0]) == "<WorldVectorEnv cluttered_room: 2 worlds, 1 agent>"
    for arrays in (simulation.model, simulation.state, worlds.episodes.state, *simulation.sensors):
        assert len(repr(arrays)) < 100


def test_editors_can_complete_what_makes_environments() -> None:
    """Explicit keywords with types, the defaults of what they make, and ``**parameters`` for the scenario's own."""
    from irsim_gym.envs.gymnasium.single import WorldEnv
    from irsim_gym.envs.gymnasium.vector import WorldVectorEnv

    makers = (irsim_gym.make, irsim_gym.make_vec, irsim_gym.parallel_env, irsim_gym.make_batch)
    for maker in (*makers, irsim_gym.sb3.make_vec_env, irsim_gym.load):
        declared = inspect.signature(maker).parameters
        assert {"render_mode", "strict"} <= set(declared)
        assert maker is irsim_gym.load or {"task", "max_steps"} <= set(declared)
        assert all(one.annotation is not inspect.Parameter.empty for one in declared.values())
        assert [one.kind for one in declared.values()].count(inspect.Parameter.VAR_KEYWORD) == 1
    for maker, made in ((irsim_gym.make, WorldEnv), (irsim_gym.make_vec, WorldVectorEnv)):
        theirs, ours = inspect.signature(made).parameters, inspect.signature(maker).parameters
        for name in set(theirs) & set(ours) - {"scenario", "num_envs", "parameters"}:
            default = theirs[name].default
            assert getattr(default, "value", default) == ours[name].default, name
        assert set(theirs) <= set(ours)
    env = irsim_gym.make("empty_goal", strict=True)
    assert env.spec is not None
    assert env.spec.kwargs == {"scenario": "empty_goal"}  # defaults are not written into a spec
