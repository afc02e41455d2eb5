"""A run remembers the parameters of its scenario: training, scoring and resuming use the same."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import Any

import pytest
from command_line import run

from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.requests.episode_setup import conditions, make_episodes
from irsim_gym.evaluation.requests.folders import evaluation_folder
from irsim_gym.evaluation.requests.remembered import remembered_parameters
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.runs.environment import make_worlds
from irsim_gym.training.settings.folders import default_folder
from irsim_gym.training.settings.run import Run, Settings

FILE = """
parameters:
  n_robots: {default: 2, min: 1, max: 9, meaning: Number of robots.}
  speed: {default: 1.0, unit: m/s, meaning: Greatest speed.}
robot:
  number: $n_robots
  kinematics: {name: diff}
  vel_max: [$speed, 1]
  behavior: {name: dash}
  distribution: {name: circle, jitter: 0.2}
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    Path("swap.yaml").write_text(FILE, encoding="utf-8")
    return "swap.yaml"


def asked(file: str, **parameters: Any) -> Settings:
    return TrainingRequest(file, "ppo", 0, 512, None, None, parameters=parameters).settings()


def test_settings_hold_all_values(file: str) -> None:
    settings = asked(file, n_robots="3")
    assert settings.parameters == {"n_robots": 3, "speed": 1.0}
    run = Run(Path("run"))
    run.begin(settings)
    assert run.settings() == settings
    assert len(make_worlds(settings, 2).worlds.scenario.bodies) == 3
    written = json.loads(run.config.read_text())
    del written["settings"]["parameters"]  # as runs wrote it before there were parameters
    run.config.write_text(json.dumps(written))
    assert run.settings().parameters == {}


def test_a_run_is_resumed_with_its_own(file: str) -> None:
    run = Run(Path("run"))
    run.begin(asked(file, n_robots=3))
    plain = TrainingRequest(file, "ppo", steps=512)
    assert plain.resumed_settings(run, asked(file, n_robots="3")).parameters["n_robots"] == 3
    with pytest.raises(IrsimGymError, match=r"run with parameters.n_robots 3, asked for: 4: its .* --from run"):
        plain.resumed_settings(run, asked(file, n_robots=4))


def test_given_parameters_name_the_folder(file: str) -> None:
    assert default_folder(file, "ppo", 0, {"n_robots": 3, "way": "a/b"}) == Path("runs/swap-n_robots=3-way=a_b-ppo-0")
    assert default_folder(file, "ppo", 0) == Path("runs/swap-ppo-0")
    assert default_folder(file, "ppo", 0, {"n_robots": 3}, "episode") == Path("runs/swap-n_robots=3-ppo-episode-0")
    assert evaluation_folder(file, "dev") == Path("runs/evaluation-swap-dev")
    assert evaluation_folder(file, "test", {"n_robots": 3}, team=True) == Path(
        "runs/evaluation-swap-n_robots=3-team-test"
    )


def begun(file: str, name: str, **parameters: Any) -> str:
    Run(Path(name)).begin(asked(file, **parameters))
    return name


def test_policies_are_driven_with_what_their_runs_were_trained_with(
    file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    three, four = begun(file, "three", n_robots=3), begun(file, "four", n_robots=4, speed=0.5)
    plain = begun(file, "plain")
    assert remembered_parameters(file, [three, "dash"]) == {"n_robots": 3}
    assert capsys.readouterr().err == "swap.yaml (n_robots = 3), as in training; use --set NAME=VALUE to change them\n"
    assert remembered_parameters(file, [f"{four}/policy.zip"]) == {"n_robots": 4, "speed": 0.5}
    assert remembered_parameters(file, [four], {"n_robots": "7"}) == {"n_robots": "7", "speed": 0.5}
    capsys.readouterr()
    assert remembered_parameters(file, [three, begun(file, "third", n_robots=3, speed=0.5)]) == {"n_robots": 3}
    assert "(speed = 1), the defaults, because the policies were trained with others" in capsys.readouterr().err
    assert remembered_parameters(file, [three, plain]) == {}
    assert "(n_robots = 2), the defaults" in capsys.readouterr().err
    assert remembered_parameters(file, [plain, "dash"]) == {}
    assert remembered_parameters(file, ["dash", "loose.zip"], {"speed": 2}) == {"speed": 2}
    Path("three/config.json").write_text("[]")
    assert remembered_parameters(file, [three]) == {}
    Path("other.yaml").write_text(FILE)
    assert remembered_parameters("other.yaml", [four]) == {}
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("command", "function"),
    [
        (["evaluate", "swap.yaml", "three", "--team"], "irsim_gym.cli.work.commands.evaluate_policies"),
        (["record", "swap.yaml", "three"], "irsim_gym.evaluation.comparison.record.record_film"),
    ],
)
def test_commands_that_take_policies_ask_their_runs(
    command: list[str], function: str, file: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun(file, "three", n_robots=3)
    zipfile.ZipFile("three/policy.zip", "w").close()
    found: list[dict[str, Any]] = []

    def driven(*arguments: Any, **named: Any) -> None:
        found.append({"asked": arguments[0], **named})
        raise IrsimGymError("enough")

    monkeypatch.setattr(function, driven)
    assert run(monkeypatch, *command) == 1
    assert found[0]["asked"].parameters == {"n_robots": 3}
    assert found[0].get("folder") in (None, Path("runs/evaluation-swap-n_robots=3-team-test"))


def test_what_a_published_figure_names(file: str) -> None:
    episodes = make_episodes(file, parameters={"n_robots": 4, "speed": 0.5})
    named = conditions(episodes, "test", 10)
    assert named["parameters"] == {"n_robots": 4, "speed": 0.5}
    assert list(named["velocity_max"]) == [0.5, 1.0]


def test_the_command_line(file: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(monkeypatch, "check", file, "--set", "n_robots=5", "--set", "speed = 1/2") == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0] == "swap.yaml: fine (robots: 5, obstacles: 0, task 'navigation')"
    assert said[1] == "  n_robots = 5        a whole number from 1 to 9   Number of robots."
    assert said[2] == "  speed = 0.5 [m/s]   a number                     Greatest speed."
    assert run(monkeypatch, "run", file, "--set", "n_robots=3", "--steps", "2") == 0
    assert "robot_2: under way" in capsys.readouterr().out
    assert run(monkeypatch, "evaluate", file, "--set", "n_robots=1", "--levels", "1") == 0
    table = Path("runs/evaluation-swap-n_robots=1-test/table.txt").read_text()
    assert "swap (n_robots = 1, speed = 1): 1 test levels" in table
    assert run(monkeypatch, "draw", file, "--set", "n_robots=1") == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--set", "n_robots"], "write NAME=VALUE, e.g. --set n_robots=8, got 'n_robots'"),
        (["--set", "a=1", "--set", "a=2"], "'a' is given twice"),
        (["--set", "seed=2"], "'seed' is no parameter of a scenario"),
        (["--set", "robots=2"], "did you mean 'n_robots'?"),
        (["--set", "n_robots=many"], "must be a whole number from 1 to 9, got 'many'"),
    ],
)
def test_mistakes_on_the_command_line(
    arguments: list[str], said: str, file: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "run", file, *arguments) == 1
    assert said in capsys.readouterr().err
