"""Arenas: comparisons worked out by hand, and what is on disk."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arena_pages import read_page
from command_line import run

import irsim_gym
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.arena.board import Board
from irsim_gym.evaluation.arena.shown_episodes import ShownEpisode, choose_episodes
from irsim_gym.evaluation.arena.standings import stand, strata_of_peers, strata_of_quarters
from irsim_gym.evaluation.comparison.evaluate import Evaluation
from irsim_gym.evaluation.levels.certificate import Certificate
from irsim_gym.evaluation.levels.played import PlayedLevels
from irsim_gym.evaluation.measures.metrics import EpisodeRow
from irsim_gym.evaluation.measures.paired import compare_pairs
from irsim_gym.evaluation.measures.team_metrics import AgentRow, TeamRow

ROOM: dict[str, Any] = {
    "world": {"height": 4, "width": 6, "step_time": 0.25},
    "robot": [
        {
            "kinematics": {"name": "diff"},
            "shape": {"name": "circle", "radius": 0.2},
            "vel_max": [1, 2],
            "state": [1, 2, 0],
            "goal": [5, 2, 0],
            "goal_threshold": 0.2,
            "sensors": [{"name": "lidar2d", "number": 8, "range_max": 2}],
        }
    ],
    "obstacle": [
        {
            "shape": {"name": "circle", "radius": 0.4},
            "distribution": {"name": "random", "range_low": [2.5, 0.5, 0], "range_high": [3.5, 3.5, 0]},
        }
    ],
    "task": {"name": "navigation", "max_steps": 30},
}
WORDS = {"s": "success", "c": "collision", "t": "timeout"}


def row(level: int, letter: str, steps: int = 10, path: float = 2.0) -> EpisodeRow:
    hit = "obstacle" if letter == "c" else ""
    return EpisodeRow(level, WORDS[letter], hit, steps, 0.1 * steps, path, 1.0, 0.3)


def board(**outcomes: str) -> Board:
    """Make a board from a letter for each level; the n-th episode of a policy takes n + 1 steps."""
    return Board.of({name: [row(i, x, i + 1) for i, x in enumerate(word)] for name, word in outcomes.items()})


def test_paired_differences() -> None:
    """Nine levels against one: 2 (1 + 10) / 2^10; the other two comparisons have 10 : 0, 2 / 2^10, and 2 : 1, 1."""
    found = board(a="s" * 9 + "cs" + "t" * 9, b="t" * 9 + "ss" + "t" * 9, c="t" * 20)
    pairs = compare_pairs(found.policies, found.success, found.spl)
    assert [(pair.one, pair.other, pair.only_one, pair.only_other) for pair in pairs] == [
        ("a", "b", 9, 1),
        ("a", "c", 10, 0),
        ("b", "c", 2, 0),
    ]
    assert [pair.p for pair in pairs] == pytest.approx([22 / 1024, 2 / 1024, 0.5])
    assert [pair.p_adjusted for pair in pairs] == pytest.approx([1.5 * 22 / 1024, 3 * 2 / 1024, 0.5])
    assert [pair.success.value for pair in pairs] == pytest.approx([0.4, 0.5, 0.1])
    assert [pair.spl.value for pair in pairs] == pytest.approx([0.2, 0.25, 0.05])  # twice the shortest path
    assert pairs[0].success.low > 0.0 > pairs[2].success.low - 1e-9


def test_easy_and_hard_levels() -> None:
    found = board(a="sstt", b="stst", c="sttt")
    peers = strata_of_peers(found)
    assert [(each.name, each.levels) for each in peers] == [
        ("0 of 2 fail", (1, 1, 1)),
        ("1 of 2 fail", (1, 1, 2)),
        ("2 of 2 fail", (2, 2, 1)),
    ]
    assert [[share.count for share in each.success] for each in peers] == [[1, 1, 1], [0, 0, 0], [1, 1, 0]]
    quarters = strata_of_quarters(found, np.array([3, 1, 2, 0]))
    assert [[share.value for share in each.success] for each in quarters] == [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 1.0],
    ]
    assert strata_of_peers(board(a="st")) == []


def test_certified_levels_are_easy_or_hard_by_their_certificate() -> None:
    """Levels that the reference fails are the harder ones; among equals, those that take longer."""
    unknown = np.zeros((4, 1), np.float32)
    certificate = Certificate(
        *("room", "", "test", ("robot",), ("dash",)),
        hash=np.zeros(4, np.uint64),
        reachable=unknown > 0,
        **dict.fromkeys(("length", "straight", "clearance"), unknown),
        least_time=np.array([[5], [1], [4], [2]], np.float32),
        density=unknown[:, 0],
        outcome=np.array([[[1], [0], [2], [0]]], np.uint8),
        time=unknown[None],
    )
    rows = {"a": [row(i, x) for i, x in enumerate("tsts")], "b": [row(i, x) for i, x in enumerate("stts")]}
    levels = PlayedLevels(4, "", "", certificate)
    played = Evaluation("room", "test", rows, [], levels, {})
    found = stand(played)
    assert found.strata_by == "by how many of dash fail, in quarters"
    assert [[share.count for share in each.success] for each in found.strata] == [[1, 0], [1, 1], [0, 0], [0, 1]]
    bare = stand(replace(played, level_set=replace(levels, certificate=None)))
    assert bare.strata_by == "by how many of the other policies fail"


def test_which_episodes_are_shown() -> None:
    """Policies take turns; short failures first, those of solved levels before others, each with the fastest way."""
    found = board(a="ctctt", b="tsstc", c="ststt")
    chosen = choose_episodes(found, 5)
    first = [ShownEpisode(0, 0), ShownEpisode(2, 0)]  # of a, and c's way
    second = [ShownEpisode(1, 0)]  # of b: c's way is there already
    third = [ShownEpisode(2, 1), ShownEpisode(1, 1)]  # of c, and b's way
    assert chosen == sorted([*first, *second, *third], key=lambda each: (each.level, each.policy))
    assert choose_episodes(found, 4) == sorted([*first, *second], key=lambda each: (each.level, each.policy))
    assert len(choose_episodes(found, 100)) == 15 - 1  # in the third level b's way stands for c's, which is as fast
    assert choose_episodes(found, 0) == []


def test_the_worst_agent_names_the_outcome_of_a_team() -> None:
    teams = {"a": [team(0, "ss"), team(1, "st"), team(2, "tc")]}
    found = Board.of(teams)
    assert [found.outcome[0, i] for i in range(3)] == [0, 2, 1]
    assert found.arrived.tolist() == [[2, 1, 0]]
    assert found.success.tolist() == [[True, False, False]]


def team(level: int, letters: str) -> TeamRow:
    agents = tuple(AgentRow(f"robot_{a}", row(level, letter), 1.0, 1.0, False) for a, letter in enumerate(letters))
    return TeamRow(level, 3.0, agents)


def test_the_files_of_an_arena(tmp_path: Path) -> None:
    """They are those of an evaluation, with the comparison beside its figures, and a page that says the same."""
    found = irsim_gym.arena(ROOM, ["dash", "random"], tmp_path / "arena", levels=6, replays=4)
    names = sorted(path.name for path in (tmp_path / "arena").iterdir())
    assert names == ["arena.html", "episodes.csv", "summary.json", "table.txt"]
    played = irsim_gym.evaluate(ROOM, ["dash", "random"], levels=6, references=False, folder=tmp_path / "same")
    for name in ("episodes.csv", "table.txt"):
        assert (tmp_path / "arena" / name).read_bytes() == (tmp_path / "same" / name).read_bytes(), name
    summary, same = (json.loads((tmp_path / folder / "summary.json").read_text()) for folder in ("arena", "same"))
    assert {name: summary[name] for name in same} == same
    assert set(summary) - set(same) == {"arena", "pairs", "difficulty"}
    assert [policy["source"] for policy in summary["arena"]["policies"]] == ["dash", "random"]
    assert found.rows == played.rows
    board, page = Board.of(found.rows), read_page(found.page)
    assert page["outcomes"] == ["".join(map(str, line)) for line in board.outcome.tolist()]
    assert (page["left"]["failures"], page["left"]["unlike"]) == (int((~board.success).sum()), 0)
    assert len(page["episodes"]) == len(page["replays"]) <= 4
    for episode, told in zip(page["episodes"], page["replays"], strict=True):
        assert episode["count"] == board.steps[told["policy"], told["level"]] + 1
    with pytest.raises(IrsimGymError, match="holds results"):
        irsim_gym.arena(ROOM, "dash", tmp_path / "arena", levels=6)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["dsh", "dash", "orcs"],
            "no policy named 'dsh' (did you mean 'dash'?)\nno policy named 'orcs' (did you mean 'orca'?)\n  ",
        ),
        ([], "an arena needs policies\n"),
        (["dash", "--split", "tset"], "no split named 'tset'"),
        (["dash", "--out", "full"], "full holds results: choose another with --out"),
    ],
)
def test_bad_calls(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("room.yaml").write_text(json.dumps(ROOM), encoding="utf-8")
    Path("full").mkdir()
    Path("full/summary.json").write_text("{}")
    assert run(monkeypatch, "arena", "room.yaml", *arguments, "--levels", "2") == 1
    assert message in capsys.readouterr().err


def test_the_page_in_docs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Its Python runs, and its commands take the options that they are shown with."""
    text = (Path(__file__).parents[3] / "docs" / "arena.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    exec(compile(block, "docs/arena.md", "exec"), {})
    assert "runs/arena/arena.html" in capsys.readouterr().out
    assert run(monkeypatch, "arena", "--help") == 0
    shown = capsys.readouterr().out
    asked = {word for line in text.splitlines() if line.startswith("irsim-gym arena") for word in line.split()}
    assert {"--levels", "--team"} <= asked
    assert all(word in shown for word in asked if word.startswith("--"))
