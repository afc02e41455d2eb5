"""docs/language.md: its examples run; the tables of options; notes on values seldom meant."""

from __future__ import annotations

import importlib
import pickle
import re
from collections.abc import Callable
from pathlib import Path

import gymnasium
import pytest
import yaml
from typer.testing import CliRunner

import irsim_gym
from irsim_gym.cli.app import app
from irsim_gym.errors import Problem, ScenarioWarning
from irsim_gym.scenario import Scenario, load_scenario
from irsim_gym.scenario.reading.notes import notes
from irsim_gym.scenario.reference.option_tables import markdown
from irsim_gym.simulator.engine import compile
from irsim_gym.tasks import load_task

DOCS = Path(__file__).parents[2] / "docs"
PAGE = DOCS / "language.md"
Load = Callable[[str], Scenario]


def test_the_command_prints_all_tables() -> None:
    assert CliRunner().invoke(app, ["options"]).output.startswith("### world\n")


def test_the_example_of_the_page_runs() -> None:
    example, *_ = re.findall(r"```yaml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(example.splitlines()) <= 20
    simulation = compile(load_scenario(yaml.safe_load(example)))
    simulation.reset(seed=0)
    simulation.step()
    assert len(simulation.scenario.bodies) == 8


def test_the_example_of_maps_by_level_has_a_level() -> None:
    _, _, example, *_ = re.findall(r"```yaml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    simulation = compile(load_scenario(yaml.safe_load(example)), 2, agents=(0,))
    simulation.reset(seed=0)
    assert (simulation.model.map_squares[0] != simulation.model.map_squares[1]).any()


def test_the_example_with_parameters_loads() -> None:
    _, example, *_ = re.findall(r"```yaml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    scenario = load_scenario(yaml.safe_load(example), {"n_robots": 12, "drive": "omni"})
    assert (scenario.name, scenario.world.width, len(scenario.bodies)) == ("swap of 12", 12.0, 12)
    assert scenario.bodies[0].vel_max[:2] == (1.0, 1.5)
    assert scenario.task["max_steps"] == 340


def test_the_example_of_a_task_is_laid_over_the_named_one() -> None:
    *_, example, _ = re.findall(r"```yaml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    world = {"robot": {"kinematics": {"name": "diff"}, "goal": [5, 5]}}
    task = load_task(load_scenario({**world, **yaml.safe_load(example)}))
    plain = load_task(load_scenario(world))
    weights = {type(term).__name__: term.weight for term in task.rewards}
    assert (task.max_steps, weights["Time"], len(weights)) == (400, 1.0, len(plain.rewards))
    observed, before = ([type(term).__name__ for term in one.observations] for one in (task, plain))
    assert observed == [*(name for name in before if name != "LastAction"), "Velocity"]


def test_the_example_of_memory_is_a_task() -> None:
    *_, example = re.findall(r"```yaml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    world = {"robot": {"kinematics": {"name": "diff"}, "goal": [5, 5], "sensors": [{"name": "lidar2d"}]}}
    task = load_task(load_scenario({**world, **yaml.safe_load(example)}))
    assert [type(term).__name__ for term in task.observations][-2:] == ["WayOnSeenMap", "SeenMapImage"]


def test_the_keys_of_a_task_are_shown() -> None:
    section = re.search(r"^### task\n(.*?)^### ", markdown(), re.DOTALL | re.MULTILINE)
    assert section is not None
    keys = ["name", "agents", "max_steps", "observation_form", "ended", "team_reward", "deadlock_speed"]
    keys += ["deadlock_time", "predict", "audit", "near", "action", "shield", "observations", "rewards", "endings"]
    assert re.findall(r"^\| `(\w+)`", section.group(1), re.MULTILINE) == keys
    shown = CliRunner().invoke(app, ["options", "task"], env={"COLUMNS": "200"}).output
    assert [key for key in keys if key not in shown] == []


def test_the_page_lists_the_parameters_of_teams_and_of_pushing() -> None:
    rows = re.findall(r"^\| `(\w+)` \| (`\w+` \d.*?) \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(rows) == 9
    for name, cell in rows:
        told = {key: float(value) for key, value in re.findall(r"`(\w+)` ([\d.]+)", cell)}
        assert told == load_scenario(name).parameters


def test_each_row_has_all_cells() -> None:
    rows = [line for line in markdown().splitlines() if line.startswith("| `")]
    assert len(rows) > 200
    assert {len(re.split(r"(?<!\\)\|", row)) for row in rows} == {8}


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("world:\n  step_time: 2", 2, "long step"),
        ("robot:\n  - {}\n  - {state: [1, 2, 90]}", 3, "a heading of 90 is more than a turn"),
        ("robot:\n  kinematics: {name: diff}\n  goal: [1, 2, 180]", 1, "a heading of 180"),
        # Strides of 3 m and 0.5 m in all, widths of 0.4 m and 2 m in all.
        (
            "world: {step_time: 1}\nrobot:\n  - {kinematics: {name: diff}, vel_max: [3, 1]}\n"
            "obstacle: {shape: {name: rectangle, length: 2, width: 5}, kinematics: {name: omni}, vel_min: [-0.5, 0]}",
            3,
            "a step of 3 m may jump over 'obstacle_1'",
        ),
        (
            "world: {obstacle_map: {name: array, cells: [[0, 0], [0, 100]]}}\nrobot:\n"
            "  - {kinematics: {name: omni}, vel_min: [0, -54.1], shape: {name: circle, radius: 0.2}}",
            3,
            "a step of 5.41 m may jump over",
        ),
        ("robot: {fov: 120, fov_radius: 3}", 1, "fov 120"),
        ("robot: {sensors: [{angle_range: 270}]}", 1, "angle_range of 270"),
        (
            "robot: {kinematics: {name: diff}, vel_max: [3, 1], goal: [5, 5]}",
            1,
            "may jump over a goal_threshold of 0.1",
        ),
        (
            "obstacle:\n  - shape: {name: circle}\n    behavior: {name: dash}",
            3,
            "add kinematics or remove the behavior",
        ),
        (
            "robot:\n- number: 3\n  group_behavior: {name: orca}",
            3,
            "the body has no kinematics, so it stands still: add kinematics or remove the group_behavior",
        ),
    ],
)
def test_values_that_are_hardly_ever_meant(text: str, line: int, words: str, tmp_path: Path) -> None:
    """Loading warns of them once, with the line, from the place of the call; ``check`` reads them without."""
    file = tmp_path / "my.world.yaml"
    file.write_text(text, encoding="utf-8")
    with pytest.warns(ScenarioWarning) as caught:
        scenario = load_scenario(file)
    (warning,) = caught
    assert warning.filename == __file__
    (note,) = notes(scenario)
    assert warning.message.problems == (note,) == notes(load_scenario(file, warn=False))
    assert note.line == line
    assert words in note.message
    assert f"{file}:{line}   " in str(warning.message)


@pytest.mark.parametrize(
    ("speed", "world", "shape"),
    [
        (4.4, "", "{name: rectangle, length: 5, width: 0.05}"),  # 0.44 m in a step; the disc and the wall are 0.45 m
        (9, "collision_check: swept", "{name: linestring, vertices: [[5, 0], [5, 9]]}"),
        (4, "", "{name: linestring, vertices: [[5, 0], [5, 9]]}"),
    ],
)
def test_strides_that_jump_over_nothing_are_not_noted(speed: float, world: str, shape: str, load: Load) -> None:
    robot = f"{{kinematics: {{name: diff}}, vel_max: [{speed}, 1], vel_min: [-{speed}, -1]}}"
    assert load(f"world: {{{world}}}\nrobot: {robot}\nobstacle: {{shape: {shape}}}").doubts == ()


def test_a_body_without_a_goal_is_noted_only(load: Load) -> None:
    (note,) = notes(load("robot: {kinematics: {name: diff}, behavior: {name: dash}}"))
    assert note.message == "has a behavior but no goal: it stands still"


def test_a_goal_outside_of_the_world_is_noted_only(load: Load) -> None:
    text = (
        "world: {width: 8, height: 6, offset: [-2, 1]}\n"
        "robot:\n"
        "  - {kinematics: {name: diff}, goal: [[-2, 1], [6, 7], [6.5, 3], [0, 0.5]]}\n"
        "  - {kinematics: {name: diff}, number: 2, goal: [9, 9]}"
    )
    scenario = load(text)  # a warning would be an error here
    where = "outside the world, which extends from (-2, 1) to (6, 7)"
    told = [(3, "(6.5, 3)"), (3, "(0, 0.5)"), (4, "(9, 9)")]
    assert {(note.line, note.message) for note in notes(scenario)} == {
        (line, f"the goal {goal} is {where}") for line, goal in told
    }
    assert len(notes(scenario)) == 3  # once for both robots of an entry


@pytest.mark.parametrize(
    "make",
    [
        lambda file: irsim_gym.load(file).close(),
        lambda file: irsim_gym.make(file).close(),
        lambda file: irsim_gym.make_vec(file, num_envs=2).close(),
        lambda file: irsim_gym.sb3.make_vec_env(file, n_envs=2).close(),
        lambda file: gymnasium.make("irsim_gym/World-v0", scenario=file).close(),
    ],
)
def test_every_way_in_warns_once(make: Callable[[str], None], tmp_path: Path) -> None:
    file = tmp_path / "world.yaml"
    file.write_text("robot: {kinematics: {name: diff}, state: [1, 1, 45], goal: [5, 5]}", encoding="utf-8")
    with pytest.warns(ScenarioWarning, match=r"world.yaml:1   robot_0: a heading of 45 is more than a turn") as caught:
        make(str(file))
    assert [warning.filename for warning in caught] == [__file__]


def test_a_warning_travels_between_processes() -> None:
    warning = ScenarioWarning("a.yaml", [Problem(3, "robot_0", "a heading of 45 is more than a turn")])
    assert str(pickle.loads(pickle.dumps(warning))) == str(warning)


def test_a_body_that_is_told_to_be_static_may_have_a_behavior(load: Load) -> None:
    assert load("obstacle: {static: true, behavior: {name: dash}}").doubts == ()


def test_nothing_is_noted_in_an_ordinary_file(load: Load) -> None:
    text = (
        "robot: {kinematics: {name: diff}, state: [1, 1, 3.2], goal: [5, 5, -pi], behavior: {name: dash},\n"
        "  sensors: [{angle_range: 6.2832}]}\n"
        "obstacle: {kinematics: {name: diff}, behavior: {name: dash, wander: true}}"
    )
    assert notes(load(text)) == ()
    assert notes(load_scenario("cluttered_room")) == ()


def test_check_prints_notes_below_a_file_that_is_fine(tmp_path: Path) -> None:
    file = tmp_path / "slow.yaml"
    file.write_text("world:\n  step_time: 2\n", encoding="utf-8")
    done = CliRunner().invoke(app, ["check", str(file)])
    assert done.exit_code == 0
    assert f"{file}:2   world.step_time: 2 s is a long step" in done.output


def test_the_page_names_each_difference(monkeypatch: pytest.MonkeyPatch) -> None:
    """The differences that tests/parity relies on are those that a user reads."""
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "parity"))
    decisions = importlib.import_module("decisions").DECISIONS
    page = (DOCS / "differences.md").read_text(encoding="utf-8")
    rows = [f"| `{name}` | {one.theirs} | {one.ours} | {one.why} |" for name, one in decisions.items()]
    missing = [row for row in rows if row not in page]
    assert not missing, "add to docs/differences.md:\n" + "\n".join(missing)
