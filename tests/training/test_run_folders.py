"""Folders of runs: their names, what they refuse, what they keep of their scenario, and how a run begins anew."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
import yaml
from command_line import run as command

import irsim_gym
from irsim_gym.errors import ChangedScenarioWarning, IrsimGymError
from irsim_gym.evaluation.requests.remembered import changes_since
from irsim_gym.evaluation.saved_policies.policies import load_policy
from irsim_gym.evaluation.saved_policies.snapshot import differences, read_snapshot, take_snapshot
from irsim_gym.scenario.reading.load import load_scenario
from irsim_gym.scenario.specs.library import find
from irsim_gym.tasks import load_task
from irsim_gym.training.requests.train import train
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.runs.fine_tuning import load_origin
from irsim_gym.training.runs.models import new_model
from irsim_gym.training.settings.folders import free_folder, sole_writer
from irsim_gym.training.settings.hyperparameters import hyperparameters_folder
from irsim_gym.training.settings.run import Run

TINY = "n_timesteps: 64, n_envs: 4, n_steps: 16, batch_size: 32, n_epochs: 1, policy_kwargs: {net_arch: [8]}"
FILE = """\
parameters: {speed: {default: 1.0, meaning: Greatest speed.}}
world: {step_time: 0.1}
robot:
  kinematics: {name: diff}
  vel_max: [$speed, 1]
  goal: [9, 9]
  sensors: [{name: lidar2d, range_max: 4}]
  plot: {show_goal: true}
task: {max_steps: 20, rewards: [{name: time, weight: 1.0}]}
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A new working directory with a scenario and hyper-parameters for short runs."""
    monkeypatch.chdir(tmp_path)
    Path("yard.yaml").write_text(FILE)
    Path("ppo.yaml").write_text(f"default: {{{TINY}}}")
    return tmp_path


def asked(scenario: str = "yard.yaml", **own: Any) -> TrainingRequest:
    return TrainingRequest(scenario, **{"hyperparameters": Path("ppo.yaml"), **own})


def begun(name: str, wanted: TrainingRequest) -> Run:
    run = Run(Path(name))
    run.begin(wanted.settings())
    return run


@pytest.mark.parametrize(
    ("own", "name"),
    [
        ({}, "empty_goal-ppo-0"),
        ({"algorithm": "sac", "seed": 3}, "empty_goal-sac-3"),
        ({"steps": 5000}, "empty_goal-ppo-steps=5000-0"),
        ({"task": "discrete_navigation", "algorithm": "dqn"}, "empty_goal-dqn-discrete_navigation-0"),
        ({"hyperparameters": "little.yaml"}, "empty_goal-ppo-little-0"),
        ({"hyperparameters": "little.yaml", "steps": 5000}, "empty_goal-ppo-little-steps=5000-0"),
    ],
)
def test_a_name_tells_what_is_not_as_usual(own: dict[str, Any], name: str) -> None:
    shipped = yaml.safe_load((hyperparameters_folder() / "ppo.yaml").read_text())
    Path("little.yaml").write_text(yaml.safe_dump({"default": {**shipped["default"], "gamma": 0.9}}))
    given = {**own, **({"hyperparameters": Path(own["hyperparameters"])} if "hyperparameters" in own else {})}
    wanted = TrainingRequest("empty_goal", **given)
    assert wanted.folder(wanted.settings()) == Path("runs") / name


def test_a_number_tells_runs_apart_whose_names_are_alike() -> None:
    wanted = asked()
    first = begun("runs/yard-ppo-0", wanted).folder
    settings = wanted.settings()
    assert free_folder(first, settings, settings.snapshot()) == (first, "")
    Path("yard.yaml").write_text(FILE.replace("step_time: 0.1", "step_time: 0.2"))
    settings = wanted.settings()
    second, said = free_folder(first, settings, settings.snapshot())
    assert second == Path("runs/yard-ppo-0-run2")
    assert said == f"{first} holds a run with other settings (world.step_time 0.1, now 0.2): this one is new"
    Run(second).begin(settings)
    assert free_folder(first, settings, settings.snapshot()) == (second, "")
    assert wanted.choose_folder(settings, resume=True, overwrite=False)[0] == second
    assert wanted.choose_folder(settings, resume=False, overwrite=True)[0] == first
    Path("ppo.yaml").write_text(f"default: {{{TINY}, gamma: 0.5}}")
    with pytest.raises(IrsimGymError, match=r"gamma 0\.995, asked for: 0\.5: its schedule cannot change during a run"):
        wanted.resumed_settings(Run(first), wanted.settings())


def test_a_refused_folder_names_what_differs(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    begun("run", asked())
    train_here = ["train", "yard.yaml", "--hyperparameters", "ppo.yaml", "--out", "run", "--dev-levels", 0]
    assert command(monkeypatch, *train_here, "--seed", 2, "--steps", 99) == 1
    said = capsys.readouterr().err
    assert "run holds a run with other settings (seed 0, asked for: 2; n_timesteps 64, asked for: 99)" in said
    assert "--out" in said
    assert "--overwrite" in said
    Path("yard.yaml").write_text(FILE.replace("range_max: 4", "range_max: 5"))
    assert command(monkeypatch, *train_here) == 1
    assert "(robot[0].sensors[0].range_max 4, now 5)" in capsys.readouterr().err
    assert command(monkeypatch, *train_here, "--resume", "--overwrite") == 1
    assert command(monkeypatch, *train_here, "--resume", "--seed", 2) == 1
    assert "seed 0, asked for: 2: its schedule cannot change during a run" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [
        ("nowhere.yaml",),
        ("yard.yaml", "--task", "navigatoin"),
        ("yard.yaml", "--set", "sped=2"),
        ("yard.yaml", "--algorithm", "dqn"),
        ("yard.yaml", "--device", "gpu"),
        ("yard.yaml", "--from", "nowhere"),
        ("yard.yaml", "--hyperparameters", "typo.yaml"),
        ("yard.yaml", "--hyperparameters", "unknown_policy.yaml"),  # found out when the model is made
    ],
)
def test_a_mistake_leaves_nothing(arguments: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    Path("typo.yaml").write_text(f"default: {{{TINY}, gama: 1}}")
    Path("unknown_policy.yaml").write_text(f"default: {{{TINY}, policy: NoPolicy}}")
    before = sorted(path.name for path in folder.iterdir())
    assert command(monkeypatch, "train", *arguments) == 1
    assert sorted(path.name for path in folder.iterdir()) == before


def test_beginning_anew(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    run = begun("run", asked(seed=5))
    (run.checkpoints / "0000000099").mkdir(parents=True)
    Path("run/notes.txt").write_text("mine")
    Path("mine").mkdir()
    Path("mine/thesis.txt").write_text("mine")
    train_anew = ["train", "yard.yaml", "--hyperparameters", "ppo.yaml", "--overwrite", "--dev-levels", 0, "--out"]
    assert command(monkeypatch, *train_anew, "mine") == 1
    assert "mine holds no training run; --overwrite replaces only runs" in capsys.readouterr().err
    assert command(monkeypatch, *train_anew[:4], "--dev-levels", 0, "--out", "ppo.yaml") == 1
    assert "--out names a folder for the results, and ppo.yaml is a file" in capsys.readouterr().err
    assert command(monkeypatch, *train_anew, "run", "--set", "sped=2") == 1
    assert run.settings().seed == 5  # the settings that are asked for cannot be used
    assert command(monkeypatch, *train_anew, "run") == 0
    assert (run.settings().seed, run.finished()) == (0, True)
    assert not (run.checkpoints / "0000000099").exists()
    assert Path("run/notes.txt").read_text() == "mine"
    assert Path("mine/thesis.txt").read_text() == "mine"


@pytest.mark.parametrize("name", ["cluttered_room", "cave", "circle_swap", "mixed_team", "social_forces"])
def test_a_copy_says_the_same(name: str, folder: Path) -> None:
    taken = take_snapshot(name, None)
    taken.write(folder / "copy")
    kept = read_snapshot(folder / "copy", taken.file)
    assert kept is not None
    assert (kept.digest, differences(kept, taken)) == (taken.digest, [])
    here, there = load_scenario(name, warn=False), load_scenario(folder / "copy" / taken.file, warn=False)
    assert there.name == here.name  # the levels follow from it
    count = len(here.bodies) - (here.occupied is not None)  # the map is the last one, and its picture has another name
    bodies = [[replace(body, line=0) for body in one.bodies[:count]] for one in (here, there)]
    assert bodies[0] == bodies[1]
    assert len(there.bodies) == len(here.bodies)
    np.testing.assert_array_equal(here.occupied, there.occupied)
    assert load_task(there, team=True) == load_task(here, team=True)


def test_a_copy_holds_parameters_maps_and_tasks_of_ones_own(folder: Path) -> None:
    Path("maps").mkdir()
    Path("maps/plan.png").write_bytes(find("cave").parents[1].joinpath("maps/cavern.png").read_bytes())
    Path("own.yaml").write_text("name: navigation\nmax_steps: 44\n")
    text = FILE.replace("{step_time: 0.1}", "{step_time: 0.1, obstacle_map: maps/plan.png}")
    Path("yard.yaml").write_text(text.replace("task: {", "task: {name: own.yaml, "))
    taken = take_snapshot("yard.yaml", None, {"speed": 0.5})
    taken.write(folder / "copy")
    Path("own.yaml").write_text("name: navigation\nmax_steps: 45\n")
    Path("maps/plan.png").write_bytes(find("cave").parents[1].joinpath("maps/floor_plan.png").read_bytes())
    there = load_scenario(folder / "copy" / "yard.yaml")
    assert there.bodies[0].vel_max == (0.5, 1.0)
    assert there.occupied is not None
    assert there.occupied.shape == load_scenario("cave").occupied.shape  # type: ignore[union-attr]
    found = differences(taken, take_snapshot("yard.yaml", None, {"speed": 0.5}))
    assert len(found) == 1
    assert found[0].startswith("world.obstacle_map 'plan-")


def test_what_is_drawn_is_no_change() -> None:
    before = take_snapshot("yard.yaml", None)
    Path("yard.yaml").write_text(FILE.replace("show_goal: true", "show_goal: false"))
    assert differences(before, take_snapshot("yard.yaml", None)) == []
    Path("yard.yaml").write_text(FILE.replace("weight: 1.0", "weight: 0.5").replace(", range_max: 4", ""))
    found = differences(before, take_snapshot("yard.yaml", None))
    assert found == ["robot[0].sensors[0].range_max 4, now nothing", "task.rewards.time.weight 1, now 0.5"]


def test_who_uses_a_policy_is_told_that_its_scenario_has_changed(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    run = train(asked().settings(), Path("run"))
    assert changes_since("yard.yaml", run.folder) == []
    Path("yard.yaml").write_text(FILE.replace("step_time: 0.1", "step_time: 0.2"))
    changed = "yard.yaml has changed since run was trained: world.step_time 0.1, now 0.2."
    capsys.readouterr()
    assert command(monkeypatch, "record", "yard.yaml", "run", "--out", "one.gif") == 0
    assert capsys.readouterr().err == f"{changed} As it was: run/scenario/yard.yaml\n"
    with pytest.warns(ChangedScenarioWarning, match=r"step_time 0\.1, now 0\.2"):
        irsim_gym.evaluate("yard.yaml", "run", levels=1, references=False)
    assert command(monkeypatch, "record", "run/scenario/yard.yaml", "run", "--out", "two.gif") == 0
    assert capsys.readouterr().err == ""
    train_here = ["train", "yard.yaml", "--hyperparameters", "ppo.yaml", "--out", "run", "--dev-levels", 1]
    assert command(monkeypatch, *train_here, "--resume") == 0
    assert "the scenario has changed since this run began (world.step_time 0.1, now 0.2)" in capsys.readouterr().err
    Path("yard.yaml").unlink()  # what is left is the run's own copy
    assert load_scenario(run.own_settings().scenario).world.step_time == 0.1


def test_a_run_under_disturbances_is_scored_under_them() -> None:
    settings = replace(asked().settings(), parameters={"disturbances": "latency:time=0.2"})
    own = train(settings, Path("run")).own_settings()
    assert [type(one).__name__ for one in own.load().disturbances] == ["Latency"]


def test_going_on_from_a_policy_with_other_settings(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    first = asked().settings()
    wanted = replace(first, hyperparameters=replace(first.hyperparameters, normalize={"norm_reward": True}))
    source = train(wanted, Path("source"))
    Path("wide.yaml").write_text(f"default: {{{TINY.replace('[8]', '[32, 32]')}, gamma: 0.5}}")
    onward = asked("empty_goal", origin="source", hyperparameters=Path("wide.yaml"), task="little.yaml")
    Path("little.yaml").write_text("name: blank\nobservations: [goal]\nrewards: [progress]\nendings: [arrived]\n")
    with pytest.raises(IrsimGymError, match=r"trained with observations of shape \(\d+,\), but this task has"):
        train(onward.settings(), Path("onward"))
    assert not Path("onward").exists()
    with pytest.raises(IrsimGymError, match="was trained with ppo, not a2c"):
        asked(origin="source", algorithm="a2c", hyperparameters=None).settings()
    settings = asked(origin="source", hyperparameters=Path("wide.yaml")).settings()
    assert settings.hyperparameters.arguments["policy_kwargs"]["net_arch"] == [8]
    assert settings.hyperparameters.arguments["gamma"] == 0.5
    assert settings.hyperparameters.normalize == {"norm_obs": True, "norm_reward": True}
    assert settings.origin is not None
    assert settings.origin["policy"] == str(source.policy.resolve())
    assert command(monkeypatch, "train", "yard.yaml", "--hyperparameters", "wide.yaml", "--from", "source") == 0
    assert "from=source" in capsys.readouterr().err
    onward_run = Run(Path("runs/yard-ppo-wide-from=source-0"))
    assert onward_run.finished()
    assert onward_run.settings().origin == settings.origin


def test_weights_and_statistics_come_along() -> None:
    from irsim_gym.training.runs.fine_tuning import copy_weights

    first = asked().settings()
    train(replace(first, hyperparameters=replace(first.hyperparameters, normalize={})), Path("source"))
    settings = asked(origin="source/policy.zip", seed=9).settings()
    model = new_model(settings)
    _, learned = load_origin("source")
    fresh = {name: value.clone() for name, value in model.policy.state_dict().items()}
    copy_weights(model, settings)
    taken = model.policy.state_dict()
    assert all(torch.equal(value, taken[name]) for name, value in learned.model.policy.state_dict().items())
    assert not all(torch.equal(value, taken[name]) for name, value in fresh.items())
    statistics: Any = model.get_vec_normalize_env()
    expected: Any = load_policy("source").normalization  # type: ignore[union-attr]
    assert (statistics.obs_rms.mean == expected.obs_rms.mean).all()
    assert statistics.obs_rms.count == expected.obs_rms.count > 1


def test_new_observations_begin_without_influence() -> None:
    from irsim_gym.training.runs.fine_tuning import copy_weights

    train(asked().settings(), Path("source"))
    Path("more.yaml").write_text("name: navigation\nobservations: [heading]\n")
    settings = asked(origin="source", task="more.yaml").settings()
    model = new_model(settings)
    copy_weights(model, settings)
    _, learned = load_origin("source")
    rows = torch.rand(5, learned.model.observation_space.shape[0])
    more = torch.cat([rows, torch.rand(5, 2)], dim=1)
    for network in (learned.model.policy, model.policy):
        network.set_training_mode(False)
    old, new = learned.model.policy.get_distribution(rows), model.policy.get_distribution(more)
    assert torch.allclose(old.mode(), new.mode(), atol=1e-6)
    assert torch.allclose(learned.model.policy.predict_values(rows), model.policy.predict_values(more), atol=1e-5)
    Path("other.yaml").write_text(
        "name: blank\nobservations: [heading, scan, goal, last_action, free_travel, goal_record, trail]\n"
        "rewards: [progress]\nendings: [arrived]\n"
    )
    with pytest.raises(IrsimGymError, match="or more observations at the end"):
        train(asked(origin="source", task="other.yaml").settings(), Path("onward"))


def test_an_evaluation_keeps_earlier_results(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    evaluate = ["evaluate", "empty_goal", "--levels", 1]
    for name in ("evaluation-empty_goal-test", "evaluation-empty_goal-test-2"):
        assert command(monkeypatch, *evaluate) == 0
        assert Path("runs", name, "summary.json").is_file()
    capsys.readouterr()
    there = Path("runs/evaluation-empty_goal-test")
    before = (there / "summary.json").stat().st_mtime_ns
    assert command(monkeypatch, *evaluate, "--out", there) == 1
    assert f"{there} holds results: choose another with --out, or replace them" in capsys.readouterr().err
    assert (there / "summary.json").stat().st_mtime_ns == before
    assert command(monkeypatch, *evaluate, "--out", there, "--overwrite") == 0
    assert (there / "summary.json").stat().st_mtime_ns > before


@pytest.mark.parametrize(
    "content", ["[]", "null", "3", '{"settings": null}', '{"settings": {"scenario": "maze"}}', "{"]
)
def test_a_config_of_another_program_is_named(content: str) -> None:
    Path("run").mkdir()
    Path("run/config.json").write_text(content)
    with pytest.raises(IrsimGymError, match=r"^run/config.json is no file with the settings of a training run: ."):
        Run(Path("run")).settings()
    Path("run/config.json").unlink()
    with pytest.raises(
        IrsimGymError, match=r"^run/config.json is no file with the settings of a training run: no such file"
    ):
        Run(Path("run")).settings()


def test_settings_with_hyperparameters_of_another_form_are_no_settings() -> None:
    run = begun("run", asked())
    data = json.loads(run.config.read_text())
    for name in ("hyperparameters", "mixture"):
        run.config.write_text(json.dumps({**data, "settings": {**data["settings"], name: [1]}}))
        with pytest.raises(IrsimGymError, match=r"^run/config.json is no file with the settings"):
            run.settings()


def test_a_second_training_in_a_folder_is_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Whatever it asks for, and before it writes anything."""
    run = begun("run", asked())
    before = {file: file.read_bytes() for file in run.folder.rglob("*") if file.is_file()}
    for option in ("--overwrite", "--resume"):
        with sole_writer(run.folder):
            asks = ["train", "yard.yaml", "--hyperparameters", "ppo.yaml", "--algorithm", "ppo"]
            assert command(monkeypatch, *asks, "--out", "run", option) == 1
        told = "another process trains into run: wait for its end, or choose another folder with --out"
        assert capsys.readouterr().err.strip().splitlines()[-1] == told
    assert {file: file.read_bytes() for file in run.folder.rglob("*") if file.is_file()} == before
