"""Runs that were trained with other tasks drive beside each other, each by what it was trained to observe."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import numpy as np
import pytest
import yaml
from arena_pages import read_page
from command_line import run as command

import irsim_gym
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.errors import UnknownPerceptionWarning
from irsim_gym.evaluation.comparison.demonstrations import DemonstrationError
from irsim_gym.evaluation.comparison.evaluate import Evaluation
from irsim_gym.evaluation.comparison.record import record_film
from irsim_gym.evaluation.comparison.recorder import record_demonstrations
from irsim_gym.evaluation.policies.policy import ObservationPolicy
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.evaluation.protocol.teams import evaluate_team
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy, UnfitPolicyError, load_policy
from irsim_gym.evaluation.suite.members import Member
from irsim_gym.evaluation.suite.playing import play_suite
from irsim_gym.evaluation.suite.row_files import read_rows
from irsim_gym.evaluation.suite.suite_record import read_record
from irsim_gym.training.requests.train import train
from irsim_gym.training.settings.hyperparameters import Hyperparameters
from irsim_gym.training.settings.run import Settings

ROBOT: dict[str, Any] = {
    "kinematics": {"name": "diff"},
    "shape": {"name": "circle", "radius": 0.2},
    "vel_max": [1, 2],
    "distribution": {"name": "random"},
    "sensors": [{"name": "lidar2d", "number": 12, "range_max": 3}],
}
OWN: dict[str, Any] = {"name": "blank", "max_steps": 25, "observations": ["velocity", "goal"]}
OWN |= {"rewards": [{"name": "progress", "weight": 1.0}], "endings": ["arrived", "collided"]}
YARD: dict[str, Any] = {
    "world": {"height": 6, "width": 6, "step_time": 0.2},
    "robot": [ROBOT],
    "obstacle": [{"number": 3, "shape": {"name": "circle", "radius": 0.4}, "distribution": {"name": "random"}}],
    "task": OWN,
}
SEEN = {"observations": [{"name": "scan", "sectors": 4}, "way_on_seen_map", "trail"], "observation_form": "dict"}
CHOICES = {"observations": ["velocity", "goal_heading"], "action": {"name": "discrete", "linear": 2, "angular": 3}}
TINY = {"n_timesteps": 256, "n_envs": 4, "n_steps": 32, "batch_size": 32, "n_epochs": 2}
NETWORKS = {"policy_kwargs": {"net_arch": [64]}}
LEVELS = 6


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a scenario, tasks, and a run of each task: the scenario's own, and two others."""
    place = tmp_path_factory.mktemp("yard")
    (place / "yard.yaml").write_text(yaml.safe_dump(YARD))
    for name, own in (("seen", SEEN), ("choices", CHOICES)):
        other = {**OWN, **own, "max_steps": 7, "rewards": [{"name": "time", "weight": 1.0}]}
        (place / f"{name}.yaml").write_text(yaml.safe_dump({**other, "endings": ["arrived"]}))
    for name, algorithm, own in (
        ("plain", "ppo", {}),
        ("seen", "gru_ppo", {"normalize": True}),
        ("choices", "ppo", {"normalize": True}),
    ):
        task = None if name == "plain" else str(place / f"{name}.yaml")
        wanted = Hyperparameters.from_plain({**TINY, **NETWORKS, **own})
        train(Settings(str(place / "yard.yaml"), algorithm, 0, task, wanted), place / name)
    return place


def alone(folder: Path, name: str, own: dict[str, Any]) -> list[Any]:
    """Return the rows of a run in the scenario's task with its observations, played by itself."""
    episodes = Worlds(folder / "yard.yaml", 3, task={**OWN, **own}).episodes
    return evaluate(load_policy(folder / name), episodes, LEVELS)


@pytest.mark.parametrize("n_worlds", [1, 4])
def test_runs_of_several_tasks_in_one_table(
    n_worlds: int, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs: list[Any] = [folder / "plain", folder / "seen", folder / "choices"]
    chosen: dict[str, Any] = {"levels": LEVELS, "n_worlds": n_worlds, "folder": tmp_path / "found"}
    found = irsim_gym.evaluate(folder / "yard.yaml", [*runs, "dash"], **chosen)
    assert isinstance(found, Evaluation)
    expected = {"plain": alone(folder, "plain", {}), "seen": alone(folder, "seen", SEEN)}
    expected |= {"choices": alone(folder, "choices", CHOICES)}
    assert {name: found.rows[name] for name in expected} == expected
    assert len({tuple(row.path_length for row in rows) for rows in found.rows.values()}) == 5
    assert found.rows["dash"] == evaluate(load_policy("dash"), Worlds(folder / "yard.yaml", 3).episodes, LEVELS)
    assert {row.steps for rows in found.rows.values() for row in rows if row.outcome == "timeout"} == {25}
    assert found.observes == {
        "plain": ["velocity", "goal"],
        "seen": ["scan", "way_on_seen_map", "trail"],
        "choices": ["velocity", "goal_heading"],
    }
    assert json.loads((tmp_path / "found" / "summary.json").read_text())["observes"] == found.observes
    assert capsys.readouterr().err.splitlines() == [
        "seen: scan, way_on_seen_map, trail, as in training, not the observations of 'blank'",
        "choices: velocity, goal_heading, as in training, not the observations of 'blank'",
    ]


def test_a_task_says_what_counts_and_what_others_observe(folder: Path) -> None:
    """An explicit task ends after 12 steps; the run goes on to observe what it knows, a function what the task says."""
    task = {**OWN, "max_steps": 12, "endings": [], "observations": ["trail"]}
    widths: set[int] = set()

    def stand(seen: np.ndarray) -> np.ndarray:
        widths.add(seen.shape[1])
        return np.tile(np.array([-1.0, 0.0]), (len(seen), 1))

    chosen: dict[str, Any] = {"levels": 3, "task": task, "references": False}
    found = irsim_gym.evaluate(folder / "yard.yaml", {"stand": stand, "run": folder / "plain"}, **chosen)
    assert {row.steps for rows in found.rows.values() for row in rows} == {12}
    assert widths == {12}
    expected = Worlds(folder / "yard.yaml", 2, task={**task, "observations": OWN["observations"]}).episodes
    assert found.rows["run"] == evaluate(load_policy(folder / "plain"), expected, 3)


def test_who_knows_what_it_observes(folder: Path, tmp_path: Path) -> None:
    checkpoint = next((folder / "seen" / "checkpoints").iterdir())
    for source in (folder / "seen", folder / "seen" / "policy.zip", checkpoint / "policy.zip"):
        policy = load_policy(source)
        assert isinstance(policy, SavedPolicy)
        assert policy.perception is not None
        assert policy.perception.names == ["scan", "way_on_seen_map", "trail"]
        assert policy.perception.observation_form == "dict"
    shutil.copy(folder / "choices" / "policy.zip", tmp_path / "bare.zip")
    bare = load_policy(tmp_path / "bare.zip")
    assert isinstance(bare, SavedPolicy)
    assert bare.perception is None
    with pytest.raises(UnfitPolicyError, match=r"bare: .* was trained with observations of shape \(\d+,\), but"):
        irsim_gym.evaluate(folder / "yard.yaml", [tmp_path / "bare.zip"], levels=1)


def test_a_run_whose_copy_cannot_be_read_observes_what_the_task_says(folder: Path, tmp_path: Path) -> None:
    shutil.copytree(folder / "plain", tmp_path / "plain")
    file = tmp_path / "plain" / "scenario" / "yard.yaml"
    file.write_text(file.read_text().replace("lidar2d", "my_lidar"))
    with pytest.warns(UnknownPerceptionWarning, match="plain: the observations of its training cannot be read"):
        policy = load_policy(tmp_path / "plain")
    episodes = Worlds(folder / "yard.yaml", 2).episodes
    assert evaluate(policy, episodes, LEVELS) == alone(folder, "plain", {})


def test_the_suite_takes_them(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    blind = {**YARD, "robot": [{**ROBOT, "sensors": []}]}
    (tmp_path / "blind.yaml").write_text(yaml.safe_dump(blind))
    members = [Member("yard", "x", str(folder / "yard.yaml")), Member("blind", "x", str(tmp_path / "blind.yaml"))]
    monkeypatch.chdir(tmp_path)
    methods = irsim_gym.evaluation.requests.methods.read_methods(
        [f"own={folder / 'seen'},{folder / 'choices'}", "dash"]
    )
    play_suite(members, methods, tmp_path / "run", levels=LEVELS)
    record = read_record(tmp_path / "run")
    entries = record.runs["yard"]["own"]
    assert [entry["observes"] for entry in entries] == [
        ["scan", "way_on_seen_map", "trail"],
        ["velocity", "goal_heading"],
    ]
    assert "observes" not in record.runs["yard"]["dash"][0]
    for entry, name, own in zip(entries, ("seen", "choices"), (SEEN, CHOICES), strict=True):
        rows = read_rows(tmp_path / "run" / entry["file"])
        expected = alone(folder, name, own)
        assert [row.agents[0].episode.outcome for row in rows] == [row.outcome for row in expected]
        assert [row.agents[0].episode.path_length for row in rows] == pytest.approx(
            [row.path_length for row in expected], abs=1e-5
        )
    refused, fitting = record.runs["blind"]["own"]
    assert "trained with scan, way_on_seen_map, trail, which does not fit" in refused["left_out"]
    assert "'robot_0' has no range sensor" in refused["left_out"]
    assert fitting["observes"] == ["velocity", "goal_heading"]


def test_the_arena_takes_them(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    asked = ["arena", folder / "yard.yaml", "--levels", LEVELS, "--replays", 8, "--out", "arena"]
    assert command(monkeypatch, *asked, folder / "seen", "dash", folder / "choices") == 0
    summary = json.loads(Path("arena/summary.json").read_text())["arena"]
    assert [policy.get("observes") for policy in summary["policies"]] == [
        ["scan", "way_on_seen_map", "trail"],
        None,
        ["velocity", "goal_heading"],
    ]
    page = read_page(Path("arena/arena.html"))
    for name, own in (("seen", SEEN), ("choices", CHOICES)):
        steps = page["steps"][page["policies"].index(name)]
        assert steps == [row.steps for row in alone(folder, name, own)]
    assert page["left"]["unlike"] == 0  # played again, each episode ends as before
    assert page["episodes"]


def test_policies_of_teams_perceive_by_their_own_tasks(folder: Path, tmp_path: Path) -> None:
    robots = [{**ROBOT, "distribution": {"name": "manual"}, "state": [1, y, 0], "goal": [5, y, 0]} for y in (1, 5)]
    (tmp_path / "pair.yaml").write_text(yaml.safe_dump({**YARD, "robot": robots, "obstacle": []}))
    policies: dict[str, Any] = {"seen": folder / "seen", "choices": folder / "choices", "dash": "dash"}
    chosen: dict[str, Any] = {"levels": 2, "team": True, "replays": 0}
    found = irsim_gym.arena(tmp_path / "pair.yaml", policies, tmp_path / "arena", **chosen)
    assert list(found.rows) == ["seen", "choices", "dash"]
    episodes = Worlds(tmp_path / "pair.yaml", 2, task={**OWN, **CHOICES}, team=True).episodes
    expected = evaluate_team(load_policy(folder / "choices"), episodes, 2)
    steps = [[agent.episode.steps for agent in row.agents] for row in expected]
    assert [[agent.episode.steps for agent in row.agents] for row in found.rows["choices"]] == steps


def test_films_show_them_side_by_side(folder: Path, tmp_path: Path) -> None:
    sources = [folder / "plain", folder / "seen", folder / "choices", "dash"]
    film = record_film(ScenarioRequest(str(folder / "yard.yaml")), sources, [2], tmp_path / "film.gif")
    steps = [alone(folder, name, own)[2].steps for name, own in (("plain", {}), ("seen", SEEN), ("choices", CHOICES))]
    steps.append(evaluate(load_policy("dash"), Worlds(folder / "yard.yaml", 1).episodes, [2])[0].steps)
    frames = iio.imread(film)
    assert len(frames) >= max(steps) + 1


def test_demonstrations_hold_what_the_policy_observes(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(DemonstrationError, match="the policy observes velocity, goal_heading, and demonstrations hold"):
        record_demonstrations(folder / "yard.yaml", str(folder / "choices"), tmp_path / "shown.npz", 1)
    task = folder / "choices.yaml"
    kept = record_demonstrations(folder / "yard.yaml", str(folder / "choices"), tmp_path / "shown.npz", 1, task=task)
    assert kept.n_episodes == 1


def test_a_function_may_have_a_perception_of_its_own(folder: Path) -> None:
    known = load_policy(folder / "choices")
    assert isinstance(known, SavedPolicy)
    widths: set[tuple[int, ...]] = set()

    def stand(seen: np.ndarray) -> np.ndarray:
        widths.add(seen.shape)
        return np.zeros(len(seen), np.int64)

    mine = ObservationPolicy(stand, known.perception)
    found = irsim_gym.evaluate(folder / "yard.yaml", {"mine": mine}, levels=1, references=False)
    assert found.observes == {"mine": ["velocity", "goal_heading"]}
    assert {width for _, width in widths} == {4}
