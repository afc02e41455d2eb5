"""Entries that name a shipped robot."""

from __future__ import annotations

from typing import Any

import jsonschema
import pytest

import irsim_gym
from irsim_gym.base.errors import ScenarioError
from irsim_gym.evaluation.saved_policies.snapshot import snapshot_of
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.reference.schema import json_schema
from irsim_gym.scenario.specs import library

ROBOTS = ("create3", "go2", "jackal", "turtlebot3_burger", "turtlebot4")


def robot(**entry: Any) -> Any:
    return load_scenario({"robot": [entry]}).bodies[0]


def test_the_shipped_robots_name_their_sources_and_can_be_played() -> None:
    assert tuple(library.names("robots")) == ROBOTS
    for name, file in library.names("robots").items():
        assert file.read_text(encoding="utf-8").startswith("# ")
        body = load_scenario(file).bodies[0]
        assert body.kinematics is not None
        assert len(body.sensors) == (name != "create3")
        world = irsim_gym.load(
            {"robot": [{"preset": name, "goal": [8, 8], "goal_threshold": 0.5, "behavior": {"name": "dash"}}]}
        )
        for _ in range(3):
            world.step()
        assert world.robot.state[0] > 0.0


def test_own_keys_come_first() -> None:
    plain = robot(preset="turtlebot4")
    assert (plain.vel_max, plain.acce, plain.shape.radius) == ((0.306, 1.9), (0.9, 7.725), 0.171)
    own = robot(preset="turtlebot4", vel_max=[0.46, 1.9], acce=None, sensors=[])
    assert (own.vel_max, own.vel_min, own.shape) == ((0.46, 1.9), plain.vel_min, plain.shape)
    assert (own.acce[0], own.sensors) == (float("inf"), ())


def test_presets_are_read_in_every_form_of_a_file() -> None:
    entry = {"preset": "jackal"}
    wrapped = {"irsim": {"robot": entry, "obstacle": [{**entry, "state": [5, 5, 0]}]}}
    by_parameter = {
        "parameters": {"kind": {"default": "go2", "meaning": "Its robot.", "choices": ["go2", "jackal"]}},
        "robot": {"preset": "$kind"},
    }
    for data, given in ((wrapped, None), ({"robot": entry}, None), (by_parameter, {"kind": "jackal"})):
        assert load_scenario(data, given).bodies[0].shape.length == 0.508
    assert load_scenario(wrapped).bodies[1].sensors[0].number == 720
    world = irsim_gym.load({"robot": {"state": [1, 1, 0]}})
    world.add_object(world.create_robot(preset="jackal", state=[5, 5, 0]))
    assert world.robot_list[1].radius > 0.3


@pytest.mark.parametrize("name", ["turtlebot5", 3, ["jackal"]])
def test_unknown_robots_are_named_with_those_that_there_are(name: object) -> None:
    with pytest.raises(ScenarioError, match=r"robot\[0\]\.preset: no robot named .*'create3', 'go2', 'jackal'"):
        robot(preset=name)


def test_the_schema_knows_the_robots() -> None:
    schema = json_schema()
    jsonschema.validate({"robot": {"preset": "go2"}}, schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"robot": {"preset": "go3"}}, schema)


def test_a_copy_of_a_scenario_holds_the_values_of_its_robot() -> None:
    data = {"robot": {"preset": "turtlebot4", "goal": [5, 5]}}
    (entry,) = [snapshot_of(load_scenario(data), None).scenario["robot"]]
    assert "preset" not in str(entry)
    assert "0.306" in str(entry)
