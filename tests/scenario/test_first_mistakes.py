"""The first mistakes of people who are new to the language: what is told has to be enough to put them right."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from irsim_gym.errors import ScenarioError
from irsim_gym.scenario import load_scenario

CAR = "robot:\n  - kinematics: {name: diff}\n"
KEYS = {
    "a size beside the shape": (
        "robot: {radius: 0.3}",
        "1 robot.radius: unknown key (did you mean 'fov_radius'? "
        "'radius' is a key of wander_goals, shape circle, distribution circle)",
    ),
    "a limit within the drive": (
        "robot: {kinematics: {name: diff, vel_max: [1, 1]}}",
        "1 robot.kinematics.vel_max: unknown key ('vel_max' is a key of robot and obstacle)",
    ),
    "a key of the world among those of bodies": (
        "robot: {plot: {no_axis: true}}",
        "1 robot.plot.no_axis: unknown key ('no_axis' is a key of world.plot)",
    ),
    "a section within another": (
        "world: {obstacle: []}",
        "1 world.obstacle: unknown key (did you mean 'obstacle_map'? 'obstacle' is a key of the file itself)",
    ),
    "a key that is not indented": (CAR + "goal: [5, 5]", "3 goal: unknown key ('goal' is a key of robot and obstacle)"),
    "a map misspelt": (
        "world: {obstacle_mpa: nowhere.png}",
        "1 world.obstacle_mpa: unknown key (did you mean 'obstacle_map'?)",
    ),
    "words in another order": (
        "robot: {sensors: {name: lidar2d, max_range: -1}}",
        "1 robot.sensors.max_range: must be > 0, got -1",
        "1 robot.sensors.max_range: unknown key (did you mean 'range_max'?)",
    ),
    "a word of others": ("gui: {mouse: {wheel: 2}}", "1 gui.mouse.wheel: unknown key; known: zoom_factor"),
    "no space": (
        "robot: {kinematics: {name:diff}}",
        "1 robot.kinematics.name: is required: 'diff', 'omni', 'omni_angular' or 'acker'",
    ),
    "a list of options": (
        "world:\n  - width: 3\n  - height: 3",
        "1 world: must be a mapping of options, got [a mapping, a mapping] (leave the '-' out)",
    ),
    "a number that is none": ("robot: {state: [1, 1, 2 * pie]}", "1 robot.state[2]: must be a number, got '2 * pie'"),
    "no commas": (
        "robot: {state: [1 -1.5 0]}",
        "1 robot.state[0]: must be a number, got '1 -1.5 0' (numbers of a list are divided by commas)",
    ),
    "a decimal comma": (
        "world: {name: a, step_time: 2,5}",
        "1 world: keys must be text, got 5; decimals have a point, as in 0.1",
    ),
}
SYNTAX = {
    "a key further in": (
        CAR + "     state: [1, 1]",
        "3 not valid YAML: indented by 5, but by 4 in line 2: items of one block must begin in the same column",
    ),
    "a key further out": (
        "world:\n  height: 10\n width: 10",
        "3 not valid YAML: indented by 1, but by 0 in line 1: items of one block must begin in the same column",
    ),
    "a list that goes on as a mapping": (
        CAR + "  state: [1, 1]",
        "3 not valid YAML: this line does not continue line 2: either all items begin with '-', or none",
    ),
    "below a value": (
        "world:\n  height: 10\n   width: 10",
        "3 not valid YAML: indented deeper than line 2, whose key already has a value",
    ),
    "a colon that sticks": (
        "world:\n  height:10\n  width: 10",
        "3 not valid YAML: line 2, above this one, is not a 'key: value' with a space after the ':'",
    ),
    "two colons": (
        "world:\n  name: a: b",
        "2 not valid YAML: a second ':' in one line: text that contains ': ' must be quoted",
    ),
    "an open brace": (
        "robot:\n  - kinematics: {name: diff\n    state: [1, 1]",
        "2 not valid YAML: the '{' that opens here is not closed, or a comma is missing, before line 3",
    ),
    "an open bracket": (
        "robot:\n  - state: [1, 1\n    goal: [2, 2]",
        "2 not valid YAML: the '[' that opens here is not closed, or a comma is missing, before line 3",
    ),
    "a bracket that is open at the end": (
        "robot:\n  - state: [1, 1\n",
        "2 not valid YAML: the '[' that opens here is not closed, or a comma is missing, before the end of the file",
    ),
    "a bracket too many": (
        "robot:\n  - state: [1, 1]]\n    goal: [2, 2]",
        "2 not valid YAML: ']' cannot follow the text before it: there is an extra mark, or two lines are joined",
    ),
    "an open quotation": (
        "robot:\n  - name: 'abc\n    goal: [2, 2]\n",
        "2 not valid YAML: the quotation mark that opens here is not closed",
    ),
    "a list beside its key": (
        "robot: - {name: a}",
        "1 not valid YAML: put the first '-' of a list on its own line, below the key",
    ),
    "a character with a meaning": (
        "world:\n  name: @home",
        "2 not valid YAML: text that begins with this character must be quoted",
    ),
}


@pytest.mark.parametrize("case", [*KEYS, *SYNTAX])
def test_what_is_told(case: str, problems: Callable[[str], list[str]]) -> None:
    text, *expected = {**KEYS, **SYNTAX}[case]
    assert [line for line in problems(text) if "name:diff" not in line] == expected


@pytest.mark.parametrize("key", ["state_dim", "vel_dim"])
def test_a_dimension_of_hundreds_of_digits_is_told_in_short(key):
    with pytest.raises(ScenarioError) as told:
        load_scenario({"robot": {"kinematics": {"name": "diff"}, key: 10**380}})
    assert all(len(problem.message) < 400 for problem in told.value.problems)
