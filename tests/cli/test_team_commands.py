"""Teams on the command line: evaluated and filmed."""

import csv
import json
from pathlib import Path

import pytest
from command_line import run

import irsim_gym

PAIR = """
world: {height: 6, width: 8}
robot:
  - {name: ann, kinematics: {name: diff}, state: [1, 2, 0], goal: [4.05, 2, 0], vel_max: [1, 1]}
  - {name: bob, kinematics: {name: KIND}, state: [1, 4, 0], goal: [5.05, 4, 0], vel_max: [1, 1]}
task: {max_steps: 60}
"""


def pair(folder: Path, kind: str = "omni") -> Path:
    file = folder / "pair.yaml"
    file.write_text(PAIR.replace("KIND", kind))
    return file


def test_evaluate(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(monkeypatch, "evaluate", pair(tmp_path), "--team", "--levels", 3, "--out", "found") == 0
    said = capsys.readouterr().out
    assert "pair: 2 agents, 3 test levels" in said
    assert "levels that all of these solved" in said
    summary = json.loads(Path("found/summary.json").read_text())
    rows = {row["policy"]: row for row in summary["policies"]}
    assert list(rows) == ["random", "dash", "rvo", "orca"]
    assert rows["dash"]["cooperative_success"]["value"] == 1.0
    assert rows["orca"]["common_extra_time"]["levels"] == 3
    assert summary["conditions"]["agents"] == ["ann", "bob"]
    assert summary["conditions"]["deadlock_time"] == 5.0
    with Path("found/episodes.csv").open() as file:
        agents = list(csv.DictReader(file))
    assert [(row["policy"], row["level"], row["agent"]) for row in agents[:3]] == [
        ("random", "0", "ann"),
        ("random", "0", "bob"),
        ("random", "1", "ann"),
    ]
    assert len(Path("found/levels.csv").read_text().splitlines()) == 1 + 4 * 3
    assert "CSR" in Path("found/table.txt").read_text()


def test_references_that_cannot_drive_all_robots_are_left_out(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    file = pair(tmp_path, "acker, wheelbase: 0.3")
    assert run(monkeypatch, "evaluate", file, "--team", "--levels", 1, "--out", "found") == 0
    assert "without rvo: 'rvo' cannot drive kinematics 'acker' of 'bob'" in capsys.readouterr().err
    summary = json.loads(Path("found/summary.json").read_text())
    assert [row["policy"] for row in summary["policies"]] == ["random", "dash"]
    assert run(monkeypatch, "evaluate", file, "orca", "--team", "--levels", 1) == 1
    assert "'orca' cannot drive kinematics 'acker' of 'bob'" in capsys.readouterr().err


def test_rows_and_record(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    film = tmp_path / "film.gif"
    found = irsim_gym.evaluate(pair(tmp_path), "dash", team=True, levels=1, references=False)
    # 3.05 m and 4.05 m at 1 m/s to within 0.1 m.
    (level,) = found.rows["dash"]
    told = [(row.agent, row.episode.outcome, row.episode.time, row.episode.path_length) for row in level.agents]
    assert told == [
        ("ann", "success", pytest.approx(3.0), pytest.approx(3.0)),
        ("bob", "success", pytest.approx(4.0), pytest.approx(4.0)),
    ]
    assert run(monkeypatch, "record", pair(tmp_path), "dash", "orca", "--team", "--out", film) == 0
    assert film.read_bytes().startswith(b"GIF")


def test_several_learners_without_the_option_are_told_of_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    file = pair(tmp_path)
    file.write_text(file.read_text().replace("max_steps: 60", "max_steps: 60, agents: all"))
    assert run(monkeypatch, "evaluate", file, "--levels", 1) == 1
    assert "needs one learner, but task 'navigation' has 2" in (said := capsys.readouterr().err)
    assert "--team" in said
    assert run(monkeypatch, "evaluate", file, "--team", "--levels", 1) == 0
