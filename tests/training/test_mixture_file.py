"""Mixture files: what they ask for, their mistakes, and the shipped ones."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from command_line import run as command

from irsim_gym.errors import IrsimGymError, ScenarioError
from irsim_gym.evaluation.suite.members import shipped_suite
from irsim_gym.scenario import load_scenario
from irsim_gym.tasks import load_task
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.settings.mixture import MixturePart, mixture_file, read_mixture, requested_mixture

TEXT = """
mixture:
  - cluttered_room
  - {scenario: crowd_nav, share: 2, parameters: {goal_change: 0.5}}
  - {scenario: rooms/mine.yaml}
task: general_navigation
algorithm: a2c
hyperparameters: fast.yaml
"""


def write(folder: Path, text: str = TEXT) -> Path:
    file = folder / "both.yaml"
    file.write_text(text)
    return file


def test_a_file_says_what_the_command_line_says(tmp_path: Path) -> None:
    file = write(tmp_path)
    found = requested_mixture([str(file)], is_mixture=False)
    assert found == requested_mixture([str(file)], is_mixture=True) == read_mixture(file)
    assert found is not None
    assert found.parts == (
        MixturePart("cluttered_room"),
        MixturePart("crowd_nav", {"goal_change": 0.5}, 2.0),
        MixturePart(str(tmp_path / "rooms/mine.yaml")),
    )
    asked = TrainingRequest(str(file), seed=3).with_mixture(found)
    assert (asked.scenario, asked.seed, asked.mixture) == ("cluttered_room", 3, found.parts)
    assert (asked.task, asked.algorithm, asked.hyperparameters) == ("general_navigation", "a2c", tmp_path / "fast.yaml")


def test_options_replace_what_the_file_states(tmp_path: Path) -> None:
    given = TrainingRequest("both.yaml", "ppo", task="navigation", hyperparameters=Path("slow.yaml"))
    asked = given.with_mixture(read_mixture(write(tmp_path)))
    assert (asked.task, asked.algorithm, asked.hyperparameters) == ("navigation", "ppo", Path("slow.yaml"))


def test_the_same_mixture_by_names_and_by_a_file_has_the_same_settings(tmp_path: Path) -> None:
    text = (
        "mixture: [maze, {scenario: crowd_nav, share: 2, parameters: {goal_change: 0.5}}]\ntask: general_navigation\n"
    )
    by_file = TrainingRequest("both.yaml").with_mixture(read_mixture(write(tmp_path, text)))
    named = requested_mixture(["maze", "crowd_nav:share=2:goal_change=0.5"], is_mixture=True)
    assert named is not None
    by_names = TrainingRequest("maze", task="general_navigation").with_mixture(named)
    assert by_file.settings() == by_names.settings()
    assert by_file.folder(by_file.settings()).name == "both-ppo-general_navigation-0"
    assert by_names.folder(by_names.settings()).name.startswith("maze_crowd_nav-share=2-goal_change=0.5-ppo")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("mixture: []", r"both.yaml:1 .*mixture: must have at least 1 values, got 0"),
        ("mixture: [maze]\ntaks: navigation", r"both.yaml:2 .*taks: unknown key \(did you mean 'task'\?\)"),
        ("mixture: [maze]\ntask: 3", r"both.yaml:2 .*task: must be text, got 3"),
        ("mixture: [7]", r"mixture\[0\]: must be a mapping of options, got 7"),
        ("mixture: [{share: 2}]", r"mixture\[0\].scenario: is required"),
        ("mixture:\n  - {scenario: maze, share: 0}", r"both.yaml:2 .*mixture\[0\].share: must be > 0, got 0"),
        ("mixture: [{scenario: maze, share: true}]", r"mixture\[0\].share: must be a number, got true"),
        ("mixture: [{scenario: maze, shares: 2}]", r"mixture\[0\].shares: unknown key \(did you mean 'share'"),
        ("mixture: [{scenario: maze, parameters: 2}]", r"parameters: must be a mapping, got 2"),
        ("mixture: [maze]\nmixture: [rooms]", r"both.yaml:2 .*mixture"),
    ],
)
def test_mistakes_are_named_with_their_lines(text: str, told: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=told):
        read_mixture(write(tmp_path, text))


def test_a_scenario_is_no_mixture_and_a_mixture_is_trained_alone(tmp_path: Path) -> None:
    scenario = write(tmp_path, "world: {width: 5}")
    assert mixture_file(str(scenario)) is None
    assert mixture_file("maze") is None
    assert requested_mixture(["maze"], is_mixture=False) is None
    with pytest.raises(IrsimGymError, match="train takes one scenario, got maze, rooms: --mixture"):
        requested_mixture(["maze", "rooms"], is_mixture=False)
    with pytest.raises(IrsimGymError, match="is a mixture of its own: train it alone, got maze, general"):
        requested_mixture(["maze", "general"], is_mixture=True)


def test_the_mixture_general_is_all_of_core_with_one_robot() -> None:
    suite = shipped_suite()
    single = [suite.members[name] for name in suite.tiers["core"] if not suite.members[name].team]
    core = {(one.scenario, *sorted(one.parameters.items())) for one in single}
    found = read_mixture(mixture_file("general"))  # type: ignore[arg-type]
    assert {(one.scenario, *sorted(one.parameters.items())) for one in found.parts} == core
    settings = TrainingRequest("general").with_mixture(found).settings()
    assert len(settings.mixture) == 6


def test_the_mixture_maze_robot_draws_disturbances_with_and_without_loops() -> None:
    found = read_mixture(mixture_file("maze_robot"))  # type: ignore[arg-type]
    assert [(one.scenario, one.parameters.get("loops")) for one in found.parts] == [("maze", None), ("maze", 0.0)]
    for one in found.parts:
        scenario = load_scenario(one.scenario, one.parameters)
        assert len(scenario.disturbances) == 6
        assert load_task(scenario, found.task).predict is True


def test_the_mixture_general_robot_has_the_scenarios_of_general_with_and_without_disturbances() -> None:
    first, late = (read_mixture(mixture_file(name)) for name in ("general", "general_robot"))  # type: ignore[arg-type]
    scenarios = [load_scenario(one.scenario, one.parameters) for one in late.parts]
    assert [(one.label, one.disturbances) for one in scenarios[1::2]] == [
        (load_scenario(one.scenario, one.parameters).label, ()) for one in first.parts
    ]
    assert [len(one.disturbances) for one in scenarios[::2]] == [6, 6, 6, 6, 6, 4]
    assert [one.share for one in late.parts[::2]] == [2.0 * one.share for one in late.parts[1::2]]
    assert [one.share for one in late.parts[::2]] == [one.share for one in first.parts]


def test_the_mixture_dense_room_memory_robot_has_worlds_with_fewer_disturbances_and_without() -> None:
    found = read_mixture(mixture_file("dense_room_memory_robot"))  # type: ignore[arg-type]
    scenarios = [load_scenario(one.scenario, one.parameters) for one in found.parts]
    assert [(one.share, len(scenario.disturbances)) for one, scenario in zip(found.parts, scenarios, strict=True)] == [
        (2.0, 6),
        (1.0, 6),
        (1.0, 0),
    ]
    assert all(load_task(scenario, found.task).predict is True for scenario in scenarios)


def test_the_mixtures_of_many_robots_have_the_same_scenarios_but_other_shares() -> None:
    first, careful = (read_mixture(mixture_file(name)) for name in ("rl_rvo", "rl_rvo_careful"))  # type: ignore[arg-type]
    assert [(one.scenario, one.parameters) for one in first.parts] == [
        (one.scenario, one.parameters) for one in careful.parts
    ]
    for mixture, task, steps in ((first, "crowded", 8_000_000), (careful, "careful", 12_000_000)):
        settings = TrainingRequest("rl_rvo").with_mixture(mixture).settings()
        assert settings.task == f"{task}_team_navigation"
        assert settings.hyperparameters.n_timesteps == steps
        assert settings.is_team


@pytest.mark.slow
def test_the_command_line_trains_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    few = {"n_timesteps": 96, "n_envs": 6, "n_steps": 16, "batch_size": 48, "checkpoint_every": 96}
    Path("few.yaml").write_text(yaml.safe_dump({"default": few}))
    text = "mixture: [maze, {scenario: crowd_nav, share: 2}]\ntask: general_navigation\nhyperparameters: few.yaml\n"
    write(tmp_path, text)
    assert command(monkeypatch, "train", "both.yaml", "--dev-levels", "2") == 0
    assert (tmp_path / "runs" / "both-ppo-general_navigation-few-0" / "policy.zip").is_file()
    assert "crowd_nav: " in capsys.readouterr().out


def test_what_a_mixture_names_wrongly_is_told_with_its_line(tmp_path: Path) -> None:
    file = write(
        tmp_path,
        "task: genral_navigation\nalgorithm: ppoo\nmixture:\n  - cluttered_rom\n  - {scenario: maz}\n"
        "  - {scenario: maze, parameters: {lops: 0.5}}\n  - {scenario: maze, parameters: {loops: 5}}\n",
    )
    with pytest.raises(ScenarioError) as told:
        read_mixture(file)
    text = str(told.value).replace(str(file), "both.yaml")
    for line in (
        "both.yaml:1   task: no task named 'genral_navigation' (did you mean 'general_navigation'?)",
        "both.yaml:2   algorithm: no algorithm named 'ppoo' (did you mean 'ppo'?)",
        "both.yaml:4   mixture[0]: no scenario named 'cluttered_rom' (did you mean 'cluttered_room'?)",
        "both.yaml:5   mixture[1].scenario: no scenario named 'maz' (did you mean 'maze'?)",
        "both.yaml:6   mixture[2].parameters.lops: ",
        "both.yaml:7   mixture[3].parameters.loops: must be a number from 0 to 1, got 5",
    ):
        assert line in text
