"""Files written for IR-SIM: what its release 2.12.0 passes over passes here too, and is told."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from irsim_gym.bodies.shapes.circle import Circle
from irsim_gym.cli.app import app
from irsim_gym.errors import IgnoredKeyWarning, ScenarioError, ScenarioWarning
from irsim_gym.scenario import Scenario, load_scenario
from irsim_gym.scenario.reading.notes import notes
from irsim_gym.tasks import load_task

NEEDLESS = """
gui:
  keyboard: {vel_max: [6, 1], key_id: 0}
robot:
  - kinematics: {name: diff}
    behavior: {name: dash, vxmax: 1.5, vymax: 1.5, acce: 1.0, factor: 2.0, wander: true}
    sensors: [{name: lidar2d, reso: 0.05}]
    plot: {show_goals: true}
obstacle:
  - kinematics: {name: diff}
    distribution: {name: random, non_overlapping: true}
    behavior: {name: rvo, vxmax: 2.0, accer: 1.0}
"""
TOLD = (
    (3, "gui.keyboard.vel_max", "key_lv_max"),
    (6, "robot[0].behavior.acce", "only rvo reads it"),
    (6, "robot[0].behavior.factor", "only rvo reads it"),
    (6, "robot[0].behavior.vxmax", "only rvo reads it"),
    (6, "robot[0].behavior.vymax", "only rvo reads it"),
    (7, "robot[0].sensors[0].reso", "angle_range and number"),
    (8, "robot[0].plot.show_goals", "show_goal draws the goal"),
    (11, "obstacle[0].distribution.non_overlapping", "random placement never overlaps"),
    (12, "obstacle[0].behavior.accer", "rvo has acce"),
)


def write(folder: Path, text: str) -> Path:
    file = folder / "theirs.yaml"
    file.write_text(text, encoding="utf-8")
    return file


def load(folder: Path, text: str, **options: Any) -> tuple[Scenario, list[ScenarioWarning]]:
    """Load a file; return the scenario and what was warned of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scenario = load_scenario(write(folder, text), **options)
    told = [one.message for one in caught]
    assert all(isinstance(one, ScenarioWarning) for one in told)
    assert {one.filename for one in caught} <= {__file__}
    return scenario, [one for one in told if isinstance(one, ScenarioWarning)]


def test_keys_that_ir_sim_passes_over_are_told_in_one_warning(tmp_path: Path) -> None:
    scenario, (warning,) = load(tmp_path, NEEDLESS)
    assert type(warning) is IgnoredKeyWarning
    assert str(warning).startswith(f"ignored in {tmp_path / 'theirs.yaml'}:\n  {tmp_path / 'theirs.yaml'}:3 ")
    for problem, (line, path, words) in zip(sorted(warning.problems), TOLD, strict=True):
        assert (problem.line, problem.path) == (line, path)
        assert words in problem.message
    behavior = scenario.bodies[1].behavior
    assert (behavior.vxmax, behavior.acce) == (2.0, 1.0)
    assert {problem.path for problem in notes(scenario)} == {path for _, path, _ in TOLD}


def test_an_option_counts_where_a_kind_has_it(tmp_path: Path) -> None:
    text = "robot: {kinematics: {name: diff}, goal: [9, 9], behavior: {name: rvo, factor: 3.0, acce: 2.0}}"
    scenario, told = load(tmp_path, text)
    assert not told
    assert (scenario.bodies[0].behavior.factor, scenario.bodies[0].behavior.acce) == (3.0, 2.0)


UNKNOWN = """
world: {height: 8, widht: 7}
robt: {kinematics: {name: diff}}
robot:
  - {kinematics: {name: diff, nois: true}, shape: {name: circle, raduis: 1}, colour: r}
obstacle:
  - {sensors: [{name: lidar2d, rnge_max: 3}], plot: {show_gaol: true}}
"""
UNKNOWN_TOLD = {
    (2, "world.widht"): "did you mean 'width'?",
    (3, "robt"): "did you mean 'robot'?",
    (5, "robot[0].kinematics.nois"): "did you mean 'noise'?",
    (5, "robot[0].shape.raduis"): "did you mean 'radius'?",
    (5, "robot[0].colour"): "did you mean 'color'?",
    (7, "obstacle[0].sensors[0].rnge_max"): "did you mean 'range_max'?",
    (7, "obstacle[0].plot.show_gaol"): "did you mean 'show_goal'?",
}


def test_unknown_keys_are_errors_unless_the_reader_is_lenient(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError) as refused:
        load_scenario(write(tmp_path, UNKNOWN))
    assert {(problem.line, problem.path) for problem in refused.value.problems} >= set(UNKNOWN_TOLD)
    assert "strict=False" in str(refused.value)
    scenario, (warning,) = load(tmp_path, UNKNOWN, strict=False)
    assert type(warning) is IgnoredKeyWarning
    told = {(problem.line, problem.path): problem.message for problem in warning.problems}
    assert set(told) == set(UNKNOWN_TOLD)
    for place, words in UNKNOWN_TOLD.items():
        assert words in told[place]
    robot, obstacle = scenario.bodies
    assert (scenario.world.width, scenario.world.height) == (10.0, 8.0)  # what a misspelt key holds is not read
    assert (robot.shape.radius, robot.kinematics.noise) == (0.2, False)
    assert (obstacle.sensors[0].range_max, obstacle.plot.show_goal) == (10.0, None)


def test_values_stay_errors_where_the_reader_is_lenient(tmp_path: Path) -> None:
    text = "world: {width: -1, foo: 1, collision_mode: 3}\nrobot: {mass: 0, sensors: [{name: sonar}]}"
    with pytest.raises(ScenarioError) as refused:
        load_scenario(write(tmp_path, text), strict=False)
    assert {problem.path for problem in refused.value.problems} == {
        "world.width",
        "world.collision_mode",
        "robot.mass",
        "robot.sensors[0].name",
    }


def test_unknown_keys_of_a_task(tmp_path: Path) -> None:
    text = "robot: {kinematics: {name: diff}, goal: [9, 9]}\ntask:\n  name: navigation\n  max_stps: 7"
    with pytest.raises(ScenarioError, match="did you mean 'max_steps'"):
        load_task(load_scenario(write(tmp_path, text)))
    with pytest.warns(IgnoredKeyWarning, match=r"theirs.yaml:4   task.max_stps: .*did you mean 'max_steps'"):
        task = load_task(load_scenario(write(tmp_path, text), strict=False))
    assert task.max_steps != 7


def test_thousands_of_unknown_keys_are_told_in_part(tmp_path: Path) -> None:
    _, (warning,) = load(tmp_path, "world:\n" + "".join(f"  k{i}: 1\n" for i in range(1000)), strict=False)
    assert len(warning.problems) == 201
    assert warning.problems[-1].message == "more than 200 keys: the rest is not shown"


@pytest.mark.parametrize("mode", ["reactive", "react"])
def test_collision_modes_that_mean_unobstructed_in_ir_sim(mode: str, tmp_path: Path) -> None:
    scenario, (warning,) = load(tmp_path, f"world:\n  collision_mode: {mode}")
    assert scenario.world.collision_mode == "unobstructed"
    (problem,) = warning.problems
    assert (problem.line, problem.path) == (2, "world.collision_mode")
    assert "do not stop" in problem.message


def test_another_collision_mode_is_an_error_unless_the_reader_is_lenient(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"did you mean 'stop'\?\)\nWith strict=False"):
        load_scenario(write(tmp_path, "world: {collision_mode: stopp}"))
    scenario, (warning,) = load(tmp_path, "world: {collision_mode: stopp}", strict=False)
    assert scenario.world.collision_mode == "unobstructed"
    assert "'stopp' is 'unobstructed'" in str(warning)


@pytest.mark.parametrize("mode", ["manual", "acker", "unobstructed"])
def test_another_control_mode_is_an_error_unless_the_reader_is_lenient(mode: str, tmp_path: Path) -> None:
    """24 of 439 files of others have one of these words; IR-SIM drives all of them by behaviours and actions."""
    text = f"world:\n  control_mode: {mode}"
    with pytest.raises(ScenarioError, match=rf"must be 'auto' or 'keyboard', got '{mode}'\nWith strict=False"):
        load_scenario(write(tmp_path, text))
    scenario, (warning,) = load(tmp_path, text, strict=False)
    assert scenario.world.control_mode == "auto"
    (problem,) = warning.problems
    assert (problem.line, problem.path) == (2, "world.control_mode")
    assert f"'{mode}' is 'auto'" in problem.message


def test_a_control_mode_that_is_no_word_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="must be 'auto' or 'keyboard', got 3"):
        load_scenario(write(tmp_path, "world: {control_mode: 3}"), strict=False)


def test_a_shape_without_a_name_is_an_error_unless_the_reader_is_lenient(tmp_path: Path) -> None:
    text = "robot:\n  shape: {radius: 0.35, center: [0.1, 0]}"
    with pytest.raises(ScenarioError, match=r"(?s)robot.shape.name: is required: 'circle'.*\nWith strict=False"):
        load_scenario(write(tmp_path, text))
    scenario, (warning,) = load(tmp_path, text, strict=False)
    assert scenario.bodies[0].shape == Circle(radius=0.35, center=(0.1, 0.0))
    assert [(one.line, one.path) for one in warning.problems] == [(2, "robot.shape")]
    with pytest.raises(ScenarioError, match=r"robot\.shape\.name: is required"):  # IR-SIM fails at these keys, too
        load_scenario(write(tmp_path, "robot: {shape: {length: 2, width: 1}}"), strict=False)


@pytest.mark.parametrize("section", ["robots", "obstacles", "worlds", "level", "parameter"])
def test_a_section_in_the_wrong_number_is_always_an_error(section: str, tmp_path: Path) -> None:
    """Files of IR-SIM 1.x have `robots` and `obstacles`: without them, the world would be empty."""
    for strict in (True, False):
        with pytest.raises(ScenarioError, match=rf"1   {section}: unknown key \(did you mean"):
            load_scenario(write(tmp_path, f"{section}:\n  - {{number: 1}}"), strict=strict)
    _, (warning,) = load(tmp_path, "people:\n  - {number: 1}", strict=False)
    assert [problem.path for problem in warning.problems] == ["people"]


@pytest.mark.parametrize(
    ("entry", "mass", "coasts"),
    [
        ("mass: 2.0", 2.0, True),
        ("mass: '2.0', kinematics: {name: static}, static: false", 2.0, True),
        ("mass: 'inf'", math.inf, False),
        ("mass: 2.0, static: true", 2.0, False),
        ("mass: 2.0, kinematics: {name: diff}", 2.0, False),
        ("kinematics: {name: diff}", 1.0, False),
        ("kinematics: {name: diff}, static: true", math.inf, False),
        ("friction: 0.3", math.inf, False),
    ],
)
def test_a_finite_mass_moves_a_body_without_a_drive(entry: str, mass: float, coasts: bool, tmp_path: Path) -> None:
    scenario, told = load(tmp_path, f"obstacle:\n  - {{{entry}}}")
    body = scenario.bodies[0]
    assert not told
    assert (body.mass, body.coasts, body.static) == (
        mass,
        coasts,
        (not coasts and "diff" not in entry) or "true" in entry,
    )


def test_a_list_has_the_masses_of_the_bodies_of_an_entry(tmp_path: Path) -> None:
    scenario, _ = load(tmp_path, "obstacle:\n  number: 4\n  mass: [1, '2']\n  friction: [0.1, 0.2, 0.3, 0.4, 0.5]")
    assert [(body.mass, body.friction) for body in scenario.bodies] == [(1, 0.1), (2, 0.2), (2, 0.3), (2, 0.4)]


def test_a_static_drive_is_none(tmp_path: Path) -> None:
    text = (
        "obstacle: [{kinematics: {name: static}, number: 2}, {kinematics: [{name: diff}, {name: static}], number: 2}]"
    )
    scenario, told = load(tmp_path, text)
    assert not told
    assert [body.static for body in scenario.bodies] == [True, True, False, True]
    assert [body.kinematics is None for body in scenario.bodies] == [True, True, False, True]
    with pytest.raises(ScenarioError, match=r"kinematics.nois: unknown key"):
        load_scenario(write(tmp_path, "obstacle: {kinematics: {name: static, nois: 1}}"))


@pytest.mark.parametrize("shape", ["rectangle", "circle"])
def test_a_wheelbase_of_nothing_moves_nothing(shape: str, tmp_path: Path) -> None:
    text = "robot: {{kinematics: {{name: {}}}, shape: {{name: {}, wheelbase: {}}}}}"
    moved, still = (load(tmp_path, text.format("diff", shape, w))[0].bodies[0].shape.outline() for w in (3, 0))
    x_moved, x_still = (
        (part.discs[0, 0] if shape == "circle" else part.segments[:, 0].mean()) for part in (moved, still)
    )
    assert (x_moved, x_still) == (1.5, 0.0)
    with pytest.raises(ScenarioError, match="the axle distance"):
        load_scenario(write(tmp_path, text.format("acker", shape, 0)))


def test_of_sections_given_twice_the_last_one_holds(tmp_path: Path) -> None:
    text = "robot:\n  - {state: [1, 1, 0], foo: 1}\nworld: {width: 3}\nrobot:\n  - {state: [2, 2, 0]}\n"
    scenario, (warning,) = load(tmp_path, text)
    assert [body.state for body in scenario.bodies] == [(2.0, 2.0, 0.0)]
    (problem,) = warning.problems
    assert type(warning) is ScenarioWarning
    assert (problem.line, problem.path) == (4, "robot")
    assert problem.message == "given twice (first in line 1): only the last one counts"


def test_blocks_of_an_entry_given_twice(tmp_path: Path) -> None:
    text = "robot:\n  - plot: {show_goal: true}\n    plot: {show_text: true}\n"
    scenario, (warning,) = load(tmp_path, text)
    assert (scenario.bodies[0].plot.show_goal, scenario.bodies[0].plot.show_text) == (None, True)
    assert [(one.line, one.path) for one in warning.problems] == [(3, "robot[0].plot")]


def test_a_value_given_twice_is_an_error_unless_the_reader_is_lenient(tmp_path: Path) -> None:
    text = "world:\n  width: 3\n  width: 4\n"
    with pytest.raises(ScenarioError, match=r"3   world.width: given twice \(first in line 2\)\nWith strict"):
        load_scenario(write(tmp_path, text))
    scenario, (warning,) = load(tmp_path, text, strict=False)
    assert scenario.world.width == 4.0
    assert "given twice (first in line 2): only the last one counts" in str(warning)


def test_a_group_behavior_of_somebody_else(tmp_path: Path) -> None:
    text = "robot: {kinematics: {name: diff}, goal: [9, 9], group_behavior: {name: flock, reach: 3}}"
    with pytest.raises(ScenarioError, match="no group behavior named 'flock'"):
        load_scenario(write(tmp_path, text))
    scenario, (warning,) = load(tmp_path, text, strict=False)
    assert scenario.bodies[0].group_behavior is None
    assert "no group behavior named 'flock'" in str(warning)


@pytest.mark.parametrize("name", ["orca", "sfm"])
def test_wander_and_loop_of_a_group_count_for_members_without_a_behavior(name: str, tmp_path: Path) -> None:
    bounds = "range_low: [1, 1, 0], range_high: [2, 2, 0]"
    text = f"""
robot:
  - {{kinematics: {{name: omni}}, group_behavior: {{name: {name}, wander: true, {bounds}}}}}
  - {{kinematics: {{name: omni}}, group_behavior: {{name: {name}, wander: true}}, behavior: {{name: dash}}}}
  - {{kinematics: {{name: omni}}, group_behavior: {{name: {name}}}, behavior: {{name: dash, wander: true}}}}
  - {{kinematics: {{name: omni}}, goal: [3, 3], group_behavior: {{name: {name}, loop: true}}}}
"""
    scenario, told = load(tmp_path, text)
    assert not told
    assert [body.wanders for body in scenario.bodies] == [True, False, True, False]
    assert scenario.bodies[0].renewal.range_high == (2.0, 2.0, 0.0)
    assert scenario.bodies[3].renewal.loop
    wrong = (
        "robot: {group_behavior: {name: orca, range_low: [3, 0, 0], range_high: [2, 1, 1]}, kinematics: {name: diff}}"
    )
    with pytest.raises(ScenarioError, match=r"range_low: must not exceed range_high"):
        load_scenario(write(tmp_path, wrong))


def test_the_command_line_is_lenient_when_asked(tmp_path: Path) -> None:
    file = str(write(tmp_path, "world: {foo: 1}\nrobot: {kinematics: {name: diff}, goal: [9, 9]}"))
    strict, lenient = (CliRunner().invoke(app, ["check", file, *flags]) for flags in ([], ["--lenient"]))
    assert (strict.exit_code, lenient.exit_code) == (1, 0)
    assert f"{file}:1   world.foo: unknown key" in lenient.output


def test_every_command_that_reads_a_scenario_can_be_lenient() -> None:
    for command in ("check", "train", "evaluate", "record", "run", "play", "draw", "warmup"):
        assert "--lenient" in CliRunner().invoke(app, [command, "--help"], env={"COLUMNS": "200"}).output, command
