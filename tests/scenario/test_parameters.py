"""The section ``parameters``: declared once, used as ``$name``, and every mistake told with its line."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from irsim_gym.errors import ScenarioError, UnknownNameError
from irsim_gym.scenario import Scenario, load_scenario
from irsim_gym.scenario.reading.parameters import describe_parameters
from irsim_gym.tasks import load_task

FILE = """
parameters:
  n_robots: {default: 4, min: 2, max: 32, meaning: Number of robots.}
  speed: {default: 1.0, min: 0.1, max: 3.0, unit: m/s, meaning: Greatest speed.}
  drive: {default: diff, choices: [diff, omni], meaning: How they drive.}
  shown: {default: false, meaning: Draw the goals.}
world: {name: "swap ${n_robots} (${shown})", width: "max(10, $n_robots / 2)"}
robot:
  - number: $n_robots
    kinematics: {name: $drive}
    vel_max: [$speed, 2 * $speed]
    distribution: {name: circle, radius: "0.4 * (4 + $n_robots)"}
    plot: {show_goal: $shown}
task: {max_steps: 100 * $n_robots}
custom: {path: $HOME, robots: $n_robots}
"""
LISTED = """\
    n_robots = 4      a whole number from 2 to 32   Number of robots.
    speed = 1 [m/s]   a number from 0.1 to 3        Greatest speed.
    drive = 'diff'    'diff' or 'omni'              How they drive.
    shown = false     true or false                 Draw the goals."""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "swap.yaml"
    path.write_text(FILE, encoding="utf-8")
    return path


def figures(scenario: Scenario) -> tuple[Any, ...]:
    body = scenario.bodies[0]
    circle = scenario.placements[0].kind
    drive = type(body.kinematics).__name__
    return scenario.name, scenario.world.width, len(scenario.bodies), drive, body.vel_max[:2], circle.radius


def test_defaults(file: Path) -> None:
    scenario = load_scenario(file)
    assert figures(scenario) == ("swap 4 (false)", 10.0, 4, "Differential", (1.0, 2.0), 3.2)
    assert scenario.parameters == {"n_robots": 4, "speed": 1.0, "drive": "diff", "shown": False}
    assert scenario.bodies[0].plot.show_goal is False
    assert load_task(scenario).max_steps == 400
    assert scenario.custom == {"path": "$HOME", "robots": 4}


def test_given_values(file: Path) -> None:
    given = {"n_robots": np.int64(32), "speed": "pi / 2", "drive": "omni", "shown": "true"}
    scenario = load_scenario(file, given)
    assert figures(scenario) == ("swap 32 (true)", 16.0, 32, "Omni", (math.pi / 2, math.pi), pytest.approx(14.4))
    assert scenario.parameters == {"n_robots": 32, "speed": math.pi / 2, "drive": "omni", "shown": True}
    assert [type(value) for value in scenario.parameters.values()] == [int, float, str, bool]
    assert load_task(scenario).max_steps == 3200
    assert pickle.loads(pickle.dumps(scenario)) == scenario
    assert load_scenario(file, {"speed": 2}).parameters["speed"] == 2.0


def test_a_name_that_is_not_declared(file: Path) -> None:
    with pytest.raises(UnknownNameError) as caught:
        load_scenario(file, {"n_robot": 3})
    assert str(caught.value) == f"{file} has no parameter 'n_robot' (did you mean 'n_robots'?); it has\n{LISTED}"
    with pytest.raises(UnknownNameError, match=r"the given mapping has no parameter 'n'; it has none$"):
        load_scenario({}, {"n": 3})
    # not itself: it would not help
    with pytest.raises(UnknownNameError, match=r"'num_envs' \(the number of worlds is 'num_envs' of make_vec"):
        load_scenario({}, {"num_envs": 3})


@pytest.mark.parametrize(
    ("name", "value", "line", "said"),
    [
        ("n_robots", 33, 3, "must be a whole number from 2 to 32, got 33"),
        ("n_robots", 4.5, 3, "must be a whole number from 2 to 32, got 4.5"),
        ("n_robots", 4.0, 3, "must be a whole number from 2 to 32, got 4.0"),
        ("n_robots", True, 3, "must be a whole number from 2 to 32, got true"),
        ("n_robots", None, 3, "must be a whole number from 2 to 32, got nothing"),
        ("speed", math.nan, 4, "must be a number from 0.1 to 3, got nan"),
        ("speed", 10**400, 4, "must be a number from 0.1 to 3, got inf"),
        ("speed", "fast", 4, "must be a number from 0.1 to 3, got 'fast'"),
        ("drive", "omi", 5, "must be 'diff' or 'omni', got 'omi' (did you mean 'omni'?)"),
        ("shown", 1, 6, "must be true or false, got 1"),
    ],
)
def test_a_value_that_is_not_allowed(name: str, value: Any, line: int, said: str, file: Path) -> None:
    with pytest.raises(ScenarioError) as caught:
        load_scenario(file, {name: value})
    (problem,) = caught.value.problems
    assert (problem.line, problem.path) == (line, f"parameters.{name}")
    assert problem.message == f"{said}; its parameters are\n{LISTED}"


def test_lines_stay_right(problems: Callable[[str], list[str]]) -> None:
    text = FILE.replace("number: $n_robots", "number: -$n_robots").replace("2 * $speed]", "2]\n    fov_radius: -$speed")
    assert problems(text) == [
        "9 robot[0].number: must be >= 0, got -4 (from -$n_robots)",
        "12 robot[0].fov_radius: must be > 0, got -1 (from -$speed)",
    ]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("robot: {number: $n}", ["1 robot.number: no parameter named 'n': there is no section 'parameters'"]),
        (
            "parameters: {n_all: {default: 4, meaning: x}}\nrobot: {number: 2 * $n_al, name: 'r${n_all}'}",
            ["2 robot.number: no parameter named 'n_al' (did you mean 'n_all'?)"],
        ),
        (
            "parameters: {n: {default: 4, meaning: x}}\nrobot: {name: 'r$n'}",
            ["2 robot.name: is not an expression; within text, write ${n}, got 'r$n'"],
        ),
        (
            "parameters: {n: {default: 4, meaning: x}}\nrobot: {number: 8 / ($n - 4)}",
            ["2 robot.number: cannot be evaluated with n = 4, got '8 / ($n - 4)'"],
        ),
        (
            "parameters: {d: {default: diff, meaning: x}}\nworld: {width: 2 * $d}",
            ["2 world.width: 'd' is 'diff', which is not a number"],
        ),
        ("parameters:\n  n: {default: 4, meaning: x}", ["2 parameters.n: is declared but never used"]),
        (
            "irsim:\n  parameters:\n    n: {default: 4, meaning: x}",
            ["3 irsim.parameters.n: is declared but never used"],
        ),
        ("parameters: 4", ["1 parameters: must be a mapping such as {n: {default: 4, meaning: ...}}, got 4"]),
        (
            "parameters: {n: 4}\nworld: {width: $n}",
            ["1 parameters.n: must be a mapping such as {default: 4, meaning: ...}, got 4"],
        ),
        (
            "parameters: {2n: {default: 4, meaning: x}, task: {default: 4, meaning: x}}",
            [
                "1 parameters.2n: a name consists of letters, digits and _, and does not begin with a digit",
                "1 parameters.task: environments have an argument of this name; choose another one",
            ],
        ),
        (
            "parameters: {n: {default: 4, text: x}}\nworld: {width: $n}",
            [
                "1 parameters.n.meaning: is required",
                "1 parameters.n.text: unknown key; known: choices, default, max, meaning, min, unit",
            ],
        ),
        (
            "parameters: {n: {default: 4, max: 3, meaning: x}}\nworld: {width: $n}",
            ["1 parameters.n.default: must be a whole number <= 3, got 4"],
        ),
        (
            "parameters: {n: {default: 4, min: 5, max: 3, meaning: x}}\nworld: {width: $n}",
            ["1 parameters.n.min: must not exceed max, got 5 and 3"],
        ),
        (
            "parameters: {d: {default: a, min: 5, meaning: x}}\nworld: {name: $d}",
            ["1 parameters.d.min: is for numbers, but the default is 'a'"],
        ),
        (
            "parameters: {d: {default: a, choices: [a, 1], meaning: x}}\nworld: {name: $d}",
            ["1 parameters.d.choices: must be of the type of the default, 'a'"],
        ),
        (
            "parameters: {d: {default: c, choices: [a, b], meaning: x}}\nworld: {name: $d}",
            ["1 parameters.d.default: must be 'a' or 'b', got 'c'"],
        ),
        (
            "parameters: {n: {default: 4, min: 1, choices: [4], meaning: x}}\nworld: {width: $n}",
            ["1 parameters.n.choices: cannot stand beside min or max"],
        ),
        (
            "parameters: {m: {default: 4, meaning: x}, n: {default: $m, meaning: x}}\nworld: {width: $n, height: $m}",
            ["1 parameters.n.default: a parameter cannot depend on other parameters"],
        ),
    ],
)
def test_mistakes_in_a_file(text: str, said: list[str], problems: Callable[[str], list[str]]) -> None:
    assert problems(text) == said


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (  # a refused declaration: nothing follows from it, be it used in a list or as what is required
            "parameters: {v: {default: 5, max: 2, meaning: x}}\n"
            "robot: [{kinematics: {name: $v}, vel_max: [1, $v], goal: [[1, 2 * $v]]}]",
            ["1 parameters.v.default: must be a whole number <= 2, got 5"],
        ),
        (  # a name that nobody declares
            "robot:\n  vel_max: [1, $v]\n  goal: [[1, 2], [$v, 0]]",
            [
                "2 robot.vel_max[1]: no parameter named 'v': there is no section 'parameters'",
                "3 robot.goal[1][0]: no parameter named 'v': there is no section 'parameters'",
            ],
        ),
        (  # other mistakes are told beside it
            "robot:\n  vel_max: [1, $v]\n  vel_min: [a, 0]",
            [
                "2 robot.vel_max[1]: no parameter named 'v': there is no section 'parameters'",
                "3 robot.vel_min[0]: must be a number, got 'a'",
            ],
        ),
        (
            "parameters: {v: {default: -5, meaning: x}, d: {default: dif, meaning: x}}\n"
            "robot: {kinematics: {name: $d}, shape: {name: circle, radius: 2 * $v}, goal_threshold: $v}",
            [
                "2 robot.goal_threshold: must be >= 0, got -5 (from $v)",
                "2 robot.kinematics.name: no kinematics named 'dif' (did you mean 'diff'?) (from $d)",
                "2 robot.shape.radius: must be > 0, got -10 (from 2 * $v)",
            ],
        ),
    ],
)
def test_nothing_follows_from_a_value_that_is_not_known(
    text: str, said: list[str], problems: Callable[[str], list[str]]
) -> None:
    assert problems(text) == said


@pytest.mark.parametrize("wrapper", ["", "irsim."])
def test_a_task_tells_the_parameter_as_well(wrapper: str) -> None:
    data = {
        "parameters": {"n": {"default": -1, "meaning": "x"}, "term": {"default": "tme", "meaning": "x"}},
        "robot": {"kinematics": {"name": "diff"}, "goal": [5, 5]},
        "task": {"max_steps": "10 * $n", "rewards": [{"name": "$term"}]},
    }
    with pytest.raises(ScenarioError) as caught:
        load_task(load_scenario({"irsim": data} if wrapper else data))
    assert [f"{problem.path}: {problem.message}" for problem in caught.value.problems] == [
        "task.max_steps: must be >= 1, got -10 (from 10 * $n)",
        "task.rewards[0].name: no reward named 'tme' (did you mean 'time'?) (from $term)",
    ]


@pytest.mark.parametrize("bounds", ["min: 0.2, max: 2", "max: 2.5", "choices: [0.5, 1, 1.5]"])
def test_a_whole_default_among_bounds_that_are_not_is_a_number(bounds: str, tmp_path: Path) -> None:
    file = tmp_path / "speed.yaml"
    file.write_text(f"parameters: {{v: {{default: 1, {bounds}, meaning: x}}}}\nrobot: {{vel_max: [$v, 1]}}")
    for given, value in (({}, 1.0), ({"v": "1.5"}, 1.5), ({"v": 1}, 1.0)):
        found = load_scenario(file, given).parameters["v"]
        assert (found, type(found)) == (value, float)
    with pytest.raises(ScenarioError, match=r"must be (a number|0\.5, 1 or 1\.5).*, got 3"):
        load_scenario(file, {"v": 3})


def test_a_name_in_braces_has_to_be_quoted_within_braces(problems: Callable[[str], list[str]]) -> None:
    hint = 'within { } or [ ], text with ${...} in it must be quoted: "${name}"'
    for text in ("robot: {shape: {name: ${n}tangle}}", "robot:\n  color: [red, ${n}]"):
        (problem,) = problems(text)
        assert hint in problem
    (problem,) = problems("world: {name: '${n}', width: [}")
    assert hint not in problem


def test_mistakes_come_together(problems: Callable[[str], list[str]]) -> None:
    told = problems("parameters: {n: {default: 4}}\nworld: {width: $n, heigth: 3}\nrobot: {number: $m}")
    assert [one.split(": ")[0] for one in told] == ["1 parameters.n.meaning", "2 world.heigth", "3 robot.number"]


def test_dollars_that_are_no_parameters_stay(load: Callable[[str], Scenario]) -> None:
    scenario = load(r"world: {name: 'costs 5 $, $\alpha$ of $x$', plot: {title: '$v_x$ in m/s'}}")
    assert scenario.name == r"costs 5 $, $\alpha$ of $x$"
    assert scenario.world.plot.title == "$v_x$ in m/s"


def test_a_description_for_people(file: Path) -> None:
    scenario = load_scenario(file, {"n_robots": 8})
    assert describe_parameters(scenario.source, scenario.parameters)[0] == (
        "n_robots = 8      a whole number from 2 to 32   Number of robots."
    )
    assert describe_parameters(load_scenario({}).source) == []
