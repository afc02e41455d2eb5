"""A saved policy drives whole teams, with a memory of its own for each robot where it is recurrent; curves of teams."""

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from irsim_gym import sb3
from irsim_gym.cli.work.commands import marks_table
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.protocol.teams import evaluate_team
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy, load_policy
from irsim_gym.tasks import Episodes
from irsim_gym.training.curves.score import score_run
from irsim_gym.training.requests.train import train
from irsim_gym.training.settings.hyperparameters import Hyperparameters
from irsim_gym.training.settings.run import Settings

PLACES = {"name": "random", "range_low": [0.5, 0.5, -3.14], "range_high": [5.5, 5.5, 3.14]}
ROBOT = {"shape": {"name": "circle", "radius": 0.2}, "distribution": PLACES, "goal_threshold": 0.4}
OWN_TASK = {"max_steps": 25, "observations": ["goal", {"name": "scan", "use": False}]}
SCENARIO = {
    "world": {"width": 6, "height": 6, "step_time": 0.1},
    "robot": [
        {**ROBOT, "number": 2, "kinematics": {"name": "diff"}, "vel_min": [0, -2], "vel_max": [2, 2]},
        {**ROBOT, "kinematics": {"name": "omni_angular"}, "vel_min": [-1, -1, -1], "vel_max": [1, 1, 1]},
    ],
    "task": OWN_TASK,
}
TINY = {"n_timesteps": 384, "n_envs": 4, "n_steps": 16, "batch_size": 64, "n_epochs": 1, "checkpoint_every": 192}


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    path = tmp_path / "three.yaml"
    path.write_text(yaml.safe_dump(SCENARIO))
    return path


def team(scenario: Path, n_worlds: int) -> Episodes:
    return Worlds(scenario, n_worlds, team=True).episodes


@pytest.mark.parametrize("own", [{}, {"normalize": True}])
def test_one_policy_drives_all_robots_in_any_number_of_worlds(own: dict[str, Any], scenario: Path) -> None:
    wanted = Hyperparameters.from_plain({**TINY, **own, "team": "episode"})
    run = train(Settings(str(scenario), "ppo", 0, None, wanted), scenario.parent / "run")
    rows = [evaluate_team(load_policy(run.folder), team(scenario, n), 6, "dev") for n in (1, 4, 6)]
    assert rows[0] == rows[1] == rows[2]
    assert {len(row.agents) for row in rows[0]} == {3}


def test_a_policy_of_another_task_is_told_apart(scenario: Path) -> None:
    wanted = Hyperparameters.from_plain({**TINY, "n_timesteps": 192, "team": "episode"})
    run = train(Settings(str(scenario), "ppo", 0, None, wanted), scenario.parent / "run")
    policy = load_policy(run.folder)
    blank = {"name": "blank", "observations": ["goal"]}
    with pytest.raises(
        IrsimGymError, match=r"observations of shape \(\d+,\), but those of task 'blank' in 'three' are"
    ):
        evaluate_team(policy, Worlds(scenario, team=True, task=blank).episodes, 1)
    choices = {**OWN_TASK, "action": {"name": "discrete", "linear": 3, "angular": 3}}
    with pytest.raises(IrsimGymError, match=r"actions of shape \(3,\), but .* are from 0 to 8"):
        evaluate_team(policy, Worlds(scenario, team=True, task=choices).episodes, 1)


def test_curve_of_a_team(scenario: Path) -> None:
    wanted = Hyperparameters.from_plain({**TINY, "team": "respawn"})
    run = train(Settings(str(scenario), "ppo", 0, None, wanted), scenario.parent / "run")
    points = score_run(run, levels=5)
    rows = evaluate_team(load_policy(run.folder), team(scenario, 5), 5, "dev")
    assert points[-1]["success"] == sum(row.is_success for row in rows) / 5
    assert points[-1]["individual_success"] == pytest.approx(sum(row.arrived for row in rows) / 15)
    assert points[-1]["makespan"] == pytest.approx(np.mean([row.makespan for row in rows]))
    with (run.folder / "curve.csv").open() as file:
        assert [int(row["steps"]) for row in csv.DictReader(file)] == [192, 384]
    assert json.loads(run.curve.read_text())["points"] == points
    assert (run.folder / "curve.png").read_bytes().startswith(b"\x89PNG")
    assert marks_table(points).title == "success of whole teams on 5 dev levels"


def recurrent(scenario: Path) -> sb3.GruPPO:
    env = sb3.make_multi_agent_vec_env(scenario, 2, 0, render_mode=None)
    arguments = {"memory_size": 8, "net_arch": [8]}
    return sb3.GruPPO("MlpGruPolicy", env, n_steps=8, batch_size=48, seed=1, device="cpu", policy_kwargs=arguments)


def test_a_recurrent_policy_remembers_for_each_robot(scenario: Path) -> None:
    model = recurrent(scenario)
    model.save(scenario.parent / "recurrent.zip")
    policy = load_policy(scenario.parent / "recurrent.zip")
    assert isinstance(policy, SavedPolicy)
    episodes, here, levels = team(scenario, 2), np.array([0, 1]), np.array([3, 4])
    episodes.begin(here, levels)
    policy.begin(episodes, here, levels)
    states: list[Any] = [[None] * 3, [None] * 3]
    for _ in range(6):
        acted = policy.act(episodes, here)
        for w in here:
            for a in range(3):
                seen = episodes.view.observation[w, a]
                expected, states[w][a] = model.predict(seen, states[w][a], deterministic=True)
                np.testing.assert_allclose(acted[w, a], expected, atol=1e-5)
        episodes.step(acted)


def test_a_recurrent_policy_forgets_the_level_before(scenario: Path) -> None:
    policy = SavedPolicy(recurrent(scenario))
    rows = [evaluate_team(policy, team(scenario, n), 6, "dev") for n in (1, 4, 6)]
    assert rows[0] == rows[1] == rows[2]
    assert evaluate_team(policy, team(scenario, 1), [5, 2], "dev") == [rows[0][5], rows[0][2]]
