"""Several seeds of one training: their folders, how they go on, and their sum."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from command_line import run as command

from irsim_gym.cli.work.seed_runs import group_folder
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.levels.draw import draw_levels
from irsim_gym.evaluation.requests.episode_setup import make_episodes
from irsim_gym.training.curves.seed_summary import named_as_runs, read_seed, seed_cells
from irsim_gym.training.export.results_files import read_results
from irsim_gym.training.requests.training_request import TrainingRequest

AGENTS = Path(__file__).parents[2] / "agents"
TINY = "n_timesteps: 64, n_envs: 4, n_steps: 16, batch_size: 32, n_epochs: 1, policy_kwargs: {net_arch: [8]}"
FILE = """\
robot:
  kinematics: {name: diff}
  goal: [9, 9]
  sensors: [{name: lidar2d, range_max: 4}]
task: {max_steps: 20, rewards: [{name: time, weight: 1.0}]}
"""
WORDS = ("train", "yard.yaml", "--hyperparameters", "ppo.yaml", "--dev-levels", 4, "--test-levels", 6)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A new working directory with a scenario and hyper-parameters for short runs."""
    monkeypatch.chdir(tmp_path)
    Path("yard.yaml").write_text(FILE)
    Path("ppo.yaml").write_text(f"default: {{{TINY}}}")
    return tmp_path


def results(place: str) -> Any:
    return json.loads(Path(place, "results.json").read_text())


def test_seeds_are_trained_and_summed_up(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert command(monkeypatch, *WORDS, "--out", "all", "--seed", 3, "--seeds", 1) == 0
    first = Path("all/seed_3/policy.zip").read_bytes()
    assert command(monkeypatch, *WORDS, "--out", "all", "--seed", 3, "--seeds", 2) == 0
    assert Path("all/seed_3/policy.zip").read_bytes() == first
    said = capsys.readouterr().out
    summary, test = results("all"), json.loads(Path("all/test/summary.json").read_text())
    assert [(seed["run"], seed["settings"]["seed"]) for seed in summary["seeds"]] == [("seed_3", 3), ("seed_4", 4)]
    assert [row["policy"] for row in test["policies"]] == ["ppo-1", "ppo-2", "random", "dash"]
    for seed, row in zip(summary["seeds"], test["policies"], strict=False):
        assert {**seed["test"], "policy": ""} == {**row, "policy": "", "worst": test["worst"][row["policy"]]}
    assert [row["policy"] for row in summary["references"]] == ["random", "dash"]
    assert summary["references"][1]["worst"] == test["worst"]["dash"]
    assert summary["worst_of_method"] == test["worst"]["ppo"]
    shares = [seed["test"]["success"]["value"] for seed in summary["seeds"]]
    assert summary["interquartile_mean_test_success"]["value"] == pytest.approx(sum(shares) / 2)
    assert test["conditions"]["levels"] == 6
    head, rows = seed_cells(summary)
    assert [cells[0] for cells in rows] == ["seed_3", "seed_4", "random", "dash"]
    assert rows[0][-1] == "64"
    assert Path("all/results.md").read_text().splitlines()[2] == f"| {' | '.join(rows[0])} |"
    assert len(head) == len(rows[0])
    assert "of seeds" not in said
    assert "median" in said
    assert Path("all/results.png").read_bytes().startswith(b"\x89PNG")
    monkeypatch.syspath_prepend(str(AGENTS / "studies"))
    import summarize

    runs = [Path("all/seed_3"), Path("all/seed_4")]
    summarize.write(summary["scenario"], runs, [Path("all/test")], "yard", Path("sum"), json_only=True)
    assert [path.name for path in Path("sum").rglob("*.*")] == ["yard.json"]
    assert json.loads(Path("sum/results/yard.json").read_text()) == summary
    (found,) = read_results(Path("all/results.json"), Path("all/seed_4"))
    assert found.seeds == (3, 4)
    assert found.result.levels == 6
    assert found.run is not None
    assert found.run["settings"]["seed"] == 4


def test_a_run_whose_last_checkpoints_have_no_scores_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    assert command(monkeypatch, *WORDS, "--out", "all", "--seeds", 1) == 0
    (run,) = Path("all").glob("seed_*")
    test = json.loads(Path("all/test/summary.json").read_text())
    named = named_as_runs(test, [run])
    assert read_seed(run, {"yard": named})["steps"] == 64
    (last,) = (run / "checkpoints").iterdir()
    shutil.copytree(last, last.with_name(f"{int(last.name) + 64:0{len(last.name)}}"))
    with pytest.raises(IrsimGymError, match=r"seed_0: 1 checkpoint\(s\) after 64 steps have no scores"):
        read_seed(run, {"yard": named})


def test_a_seed_of_several_is_the_run_of_that_seed(monkeypatch: pytest.MonkeyPatch) -> None:
    assert command(monkeypatch, *WORDS, "--out", "all", "--seed", 1, "--seeds", 1) == 0
    assert command(monkeypatch, *WORDS, "--out", "alone", "--seed", 1) == 0
    curves = [
        [{**point, "training_seconds": 0, "cpu_seconds": 0} for point in json.loads(Path(place).read_text())["points"]]
        for place in ("all/seed_1/curve.json", "alone/curve.json")
    ]
    assert curves[0] == curves[1]


def test_seeds_go_on_where_they_were_stopped(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of three seeds one is finished, one is unfinished, and one has not begun."""
    assert command(monkeypatch, *WORDS, "--out", "all/seed_0") == 0
    assert command(monkeypatch, *WORDS, "--out", "all/seed_1", "--seed", 1) == 0
    Path("all/seed_1/policy.zip").unlink()
    capsys.readouterr()
    assert command(monkeypatch, *WORDS, "--out", "all", "--seeds", 3) == 1
    assert "all/seed_1 holds an unfinished run; continue it with --resume" in capsys.readouterr().err
    assert command(monkeypatch, *WORDS, "--out", "all", "--seeds", 3, "--resume") == 0
    assert [seed["run"] for seed in results("all")["seeds"]] == ["seed_0", "seed_1", "seed_2"]


def test_no_seed_is_trained_if_another_cannot_be(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """All problems are reported at once."""
    assert command(monkeypatch, *WORDS, "--out", "all/seed_1", "--seed", 7, "--dev-levels", 0) == 0
    Path("all/seed_2").write_text("a file")
    config = Path("all/seed_1/config.json").read_bytes()
    capsys.readouterr()
    for how in ((), ("--resume",), ("--overwrite",)):
        assert command(monkeypatch, *WORDS, "--out", "all", "--seeds", 3, *how) == 1
        said = capsys.readouterr().err
        assert "all/seed_2 is a file" in said
        assert ("all/seed_1 holds a run with" in said) == (how != ("--overwrite",))
        assert [path.name for path in sorted(Path("all").iterdir())] == ["seed_1", "seed_2"]
    Path("all/seed_2").unlink()
    Path("all/seed_1/config.json").rename("all/seed_1/other.json")
    assert command(monkeypatch, *WORDS, "--out", "all", "--seeds", 3, "--overwrite") == 1
    assert "all/seed_1 holds no training run; --overwrite replaces only runs" in capsys.readouterr().err
    assert Path("all/seed_1/other.json").read_bytes() == config
    assert not Path("all/seed_0").exists()


def test_levels_that_a_file_lacks_are_missed_before_the_training(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    drawn = draw_levels(make_episodes("yard.yaml").simulation, ["train", "dev", "test"], 3)
    Path("three.npz").write_bytes(drawn.content())
    Path("yard.yaml").write_text(f"{FILE}levels: three.npz\n")
    for levels, seeds, said in (
        ((4, 3), (), "--dev-levels 4: .*three.npz has 3 dev levels, but 4 are asked for"),
        ((4, 3), ("--seeds", 2), "--dev-levels 4: .*three.npz has 3 dev levels, but 4 are asked for"),
        ((3, 6), ("--seeds", 2), "--test-levels 6: .*three.npz has 3 test levels, but 6 are asked for"),
    ):
        counts = ("--dev-levels", levels[0], "--test-levels", levels[1])
        assert command(monkeypatch, *WORDS, *counts, "--out", "all", *seeds) == 1
        assert re.search(said, capsys.readouterr().err)
        assert not Path("all").exists()
    assert command(monkeypatch, *WORDS, "--dev-levels", 3, "--test-levels", 9, "--out", "all") == 0
    Path("all/policy.zip").unlink()
    capsys.readouterr()
    assert command(monkeypatch, *WORDS, "--dev-levels", 4, "--out", "all", "--resume") == 1
    assert "three-" in capsys.readouterr().err  # the copy of the run
    assert not Path("all/policy.zip").exists()


def test_what_does_not_go_with_seeds(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert command(monkeypatch, *WORDS, "--dev-levels", 0, "--seeds", 2) == 1
    assert "--dev-levels must be at least 1" in capsys.readouterr().err
    assert not Path("runs").exists()


def test_the_folder_above_is_named_as_a_run() -> None:
    asked = TrainingRequest("yard.yaml", seed=10, hyperparameters=Path("ppo.yaml"))
    assert asked.folder(asked.settings()).name.endswith("-10")
    assert group_folder(asked).name == asked.folder(asked.settings()).name.removesuffix("10") + "seeds"


def test_teams_are_summed_up(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    words = ("train", "circle_swap", "--set", "n_robots=2", "--hyperparameters", "ppo.yaml", "--team", "episode")
    levels = ("--dev-levels", 2, "--test-levels", 2)
    assert command(monkeypatch, *words, *levels, "--out", "team", "--seeds", 2) == 0
    summary = results("team")
    (label,) = summary["conditions"]
    assert label == "n_robots=2, jitter=0.4"
    assert [seed["test"][label]["policy"] for seed in summary["seeds"]] == ["seed_0", "seed_1"]
    assert "CSR" in capsys.readouterr().out
