"""Training with plugins that are functions, one of each family, from the command line."""

from __future__ import annotations

import pickle
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import torch
import yaml
from command_line import run

from irsim_gym.base import families
from irsim_gym.evaluation.saved_policies.saved_models import load_model

PLUGINS = """
import irsim_gym
from irsim_gym.plugins import Outcome


@irsim_gym.sensor("level_sensor", size=2)
def level_sensor(ego, *, deviation: float = 0.1):
    return ego.normal(0.0, deviation), ego.velocity[0]


@irsim_gym.drive("wheels", command=["left", "right"], steer=lambda ego, velocity: [velocity[0], velocity[0]])
def wheels(ego, command):
    left, right = command
    return (left + right) / 2, 0.0, (right - left) / 0.4


@irsim_gym.behavior("circles")
def circles(ego, others):
    ego.memory["steps"] = ego.memory.get("steps", 0) + 1
    return 0.2, 0.3


@irsim_gym.placement("left_edge")
def left_edge(ego, others):
    return 1.0, ego.uniform(1.0, 5.0), 0.0


@irsim_gym.action("half")
def half(ego, given):
    return 0.5 * given


@irsim_gym.observation("sensed", size=2)
def sensed(ego):
    return 0.1 * ego.reading("level_sensor")


@irsim_gym.reward("spin")
def spin(ego):
    return -0.1 * abs(ego.action[0] - ego.action[1])


@irsim_gym.ending("far", outcome=Outcome.COLLISION)
def far(ego):
    return ego.position[0] > 5.0
"""
SCENARIO = {
    "world": {"width": 6, "height": 6},
    "robot": {
        "kinematics": {"name": "wheels"},
        "shape": {"name": "circle", "radius": 0.2},
        "vel_min": [-1, -1],
        "vel_max": [1, 1],
        "distribution": {"name": "left_edge"},
        "goal": [4, 3],
        "sensors": [{"name": "level_sensor"}],
    },
    "obstacle": {
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": 0.2},
        "behavior": {"name": "circles"},
        "state": [5, 5, 0],
    },
    "task": {
        "name": "blank",
        "max_steps": 12,
        "action": {"name": "half"},
        "observations": ["goal", "sensed"],
        "rewards": ["progress", {"name": "spin", "weight": 0.1}],
        "endings": ["arrived", "far"],
        "audit": False,
    },
}
TINY = {"n_timesteps": 192, "n_envs": 4, "n_steps": 16, "batch_size": 32, "n_epochs": 1, "checkpoint_every": 128}
KINDS = [
    (families.SENSORS, "level_sensor"),
    (families.KINEMATICS, "wheels"),
    (families.BEHAVIORS, "circles"),
    (families.PLACEMENTS, "left_edge"),
    (families.ACTIONS, "half"),
    (families.OBSERVATIONS, "sensed"),
    (families.REWARDS, "spin"),
    (families.ENDINGS, "far"),
]


@pytest.fixture
def forget(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], None]]:
    """Be in a folder with the files, and return a function that forgets the plugins, as a new process does."""
    families.load()
    known = {family: dict(family._entries) for family in families.every()}
    (tmp_path / "own_functions.py").write_text(PLUGINS)
    (tmp_path / "world.yaml").write_text(yaml.safe_dump(SCENARIO))
    (tmp_path / "tiny.yaml").write_text(yaml.safe_dump({"default": {**TINY, "policy_kwargs": {"net_arch": [8]}}}))
    (tmp_path / "space.yaml").write_text("hyperparameters: {gamma: [0.9, 0.99]}\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))

    def forget_plugins() -> None:
        sys.modules.pop("own_functions", None)
        for family, entries in known.items():
            family._entries.clear()
            family._entries.update(entries)

    yield forget_plugins
    forget_plugins()


def weights(file: Path) -> torch.Tensor:
    return torch.cat([value.flatten() for value in load_model(file)[0].policy.state_dict().values()])


def test_all_commands_go_with_functions_of_every_family(
    forget: Callable[[], None],
    interrupt: Callable[[int, int], None],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def command(*words: Any) -> int:
        forget()
        return run(monkeypatch, *words, "--import", "own_functions.py")

    train = ["train", "world.yaml", "--hyperparameters", "tiny.yaml", "--dev-levels", 2]
    assert command(*train, "--out", "whole") == 0
    interrupt(100, signal.SIGINT)
    assert command(*train, "--out", "parts") == 130
    assert command(*train, "--out", "parts", "--resume") == 0
    assert torch.equal(weights(Path("whole/policy.zip")), weights(Path("parts/policy.zip")))
    tune = ["tune", "world.yaml", "--hyperparameters", "tiny.yaml", "--dev-levels", 2, "--space", "space.yaml"]
    assert command(*tune, "--trials", 1, "--out", "study") == 0
    export = ["policies", "export", "parts", "mine", "--levels", 2]
    assert command(*export, "--out", "shelf") == 0
    assert command("evaluate", "world.yaml", "parts", "shelf/mine.npz", "--levels", 2) == 0
    capsys.readouterr()


@pytest.mark.usefixtures("forget")
def test_a_pickle_holds_the_name_of_a_kind_that_is_made_from_a_function() -> None:
    exec(compile(PLUGINS, "own_functions.py", "exec", dont_inherit=True), {"__name__": "own_functions"})
    for family, name in KINDS:
        made = family.entry(name).kind
        content = pickle.dumps([made, made()])
        kind, instance = pickle.loads(content)
        assert kind is made, name
        assert type(instance) is made, name
        del family._entries[name]
        with pytest.raises(Exception, match=f"no {family.family} named '{name}'"):
            pickle.loads(content)


@pytest.mark.parametrize("weight", [1.0, 3.0])
@pytest.mark.parametrize(
    ("answer", "said"),
    [
        ("None", "reward 'own' must return one number for 'robot_0', got None"),
        ("0.5", "a running term is never positive: write -amount"),
        ("1 / 0", "ZeroDivisionError"),
    ],
)
def test_check_tells_what_a_reward_does_beside_what_it_weighs(
    weight: float,
    answer: str,
    said: str,
    forget: Callable[[], None],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    Path("own_reward.py").write_text(
        f"import irsim_gym\n\n\n@irsim_gym.reward('own')\ndef own(ego):\n    return {answer}\n"
    )
    task = {"name": "navigation", "rewards": [{"name": "own", "weight": weight}]}
    robot = {**SCENARIO["robot"], "kinematics": {"name": "diff"}, "sensors": [], "state": [1, 3, 0]}
    del robot["distribution"]
    task["observations"] = [{"name": name, "use": False} for name in ("scan", "free_travel", "trail")]
    Path("own.yaml").write_text(yaml.safe_dump({"world": SCENARIO["world"], "robot": robot, "task": task}))
    sys.modules.pop("own_reward", None)
    assert run(monkeypatch, "check", "own.yaml", "--import", "own_reward.py") == 1
    told = capsys.readouterr().err
    sys.modules.pop("own_reward", None)
    forget()
    assert said in told
    assert ("one that continues can cost 6" in told) == (weight == 3.0)
