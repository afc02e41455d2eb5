import csv
import io
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from irsim_gym.errors import UnreadableFileError
from irsim_gym.evaluation.measures.metrics import EpisodeRow, summarize
from irsim_gym.evaluation.measures.team_metrics import AgentRow, TeamRow
from irsim_gym.evaluation.protocol.figure_columns import summary_table
from irsim_gym.evaluation.protocol.progress_bars import progress_bar
from irsim_gym.evaluation.protocol.tables import (
    figure_table,
    legend,
    plain,
    table_text,
    write_bytes,
    write_episodes,
    write_json,
)
from irsim_gym.evaluation.suite.row_files import read_rows, write_rows

ROWS = [
    EpisodeRow(0, "success", "", 20, 2.0, 5.0, 4.0, 0.25),
    EpisodeRow(1, "collision", "obstacle", 7, 0.7, 1.0, math.inf, 0.0),
]


def test_episodes_as_csv(tmp_path: Path) -> None:
    write_episodes(tmp_path / "deep" / "episodes.csv", {"dash": ROWS})
    with (tmp_path / "deep" / "episodes.csv").open() as file:
        first, second = csv.DictReader(file)
    assert first["policy"] == "dash"
    assert (first["outcome"], float(first["spl"]), float(first["path_ratio"])) == ("success", 0.8, 1.25)
    assert (second["hit"], second["optimum"], second["path_ratio"]) == ("obstacle", "inf", "")


def test_json_says_null_for_what_is_not_a_number(tmp_path: Path) -> None:
    write_json(tmp_path / "summary.json", {"rows": [summarize("dash", ROWS[1:])], "n": np.int64(3), "x": math.nan})
    data = json.loads((tmp_path / "summary.json").read_text())
    assert data["rows"][0]["time"] is None
    assert (data["n"], data["x"]) == (3, None)
    assert (data["rows"][0]["collision"]["count"], data["rows"][0]["goals_per_collision"]) == (1, 0.0)
    assert plain(Path("a")) == "a"


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "table.txt"
    write_bytes(target, b"old")

    def fail(self: Path, other: Path) -> None:
        raise OSError("no space left")

    monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(OSError, match="no space"):
        write_bytes(target, b"new")
    assert target.read_bytes() == b"old"
    assert [file.name for file in tmp_path.iterdir()] == ["table.txt"]


def test_copies_of_one_episode_have_no_interval() -> None:
    """20 equal episodes are one, whose share is exact; one that differs makes them a sample."""
    alike = [replace(ROWS[0], level=level) for level in range(20)]
    summary = summarize("dash", alike)
    assert (summary.success.low, summary.success.high) == (1.0, 1.0)
    table = summary_table([summary], "one level")
    assert table_text(table).splitlines()[-2].split()[:3] == ["dash", "100.0", "-"]
    assert legend([table], [summary.success]).splitlines()[-1].startswith("95 % interval: none (-)")
    other = summarize("dash", [*alike[1:], replace(ROWS[0], path_length=2.6)])
    assert other.success.low == pytest.approx(0.839, abs=5e-4)  # Wilson: 20 / (20 + 1.96^2)


def test_a_legend_explains_the_columns_that_are_shown() -> None:
    lines = legend([summary_table([summarize("dash", ROWS)], "set 12ab")], [])
    assert [line.split(":")[0] for line in lines.splitlines()] == ["SPL", "path ratio", "clear.", "goals /hit", "set"]


def test_table_shows_the_split_of_collisions_only_where_there_is_one() -> None:
    text = table_text(summary_table([summarize("dash", ROWS)], "cluttered_room"))
    assert text.splitlines()[0] == "cluttered_room"
    assert "with obstacle" not in text
    # 1 of 2, 1 goal for 1 collision, SPL 0.8 / 2, clearance 0.25 / 2
    cells = ["dash", "50.0", "9.5-90.5", "50.0", "1.0", "0.0", "0.400", "2.00", "1.250", "0.125"]
    assert cells in [line.split() for line in text.splitlines()]
    assert "[s]" in text
    assert max(map(len, text.splitlines())) <= 80
    moving = EpisodeRow(2, "collision", "moving obstacle", 7, 0.7, 1.0, 2.0, 0.0)
    heads = [str(column.header) for column in summary_table([summarize("dash", [*ROWS, moving])], "t").columns]
    assert heads[3:6] == ["collided\n[%]", "with obstacle\n[%]", "with moving obstacle\n[%]"]


def test_titles_and_names_that_look_like_markup_are_text() -> None:
    text = table_text(figure_table("[/red] [bold]x", ["policy", "[b]"], [["[/]", "1"]]))
    assert text.splitlines()[0].strip() == "[/red] [bold]x"
    assert "[/]" in text
    assert "[b]" in text
    with progress_bar(Console(file=(room := io.StringIO()), force_terminal=True)) as bar:
        bar.add_task("[/red] plays", total=1)
        bar.refresh()
    assert "[/red] plays" in room.getvalue()


def edited(file: Path, *edits: tuple[str, str]) -> str:
    """Return what is told of a file of rows after some edits of its text."""
    robots = [AgentRow("robot_0", replace(ROWS[k % 2], level=k), 4.0, 1.0, False) for k in range(4)]
    write_rows(file, [TeamRow(k, 30.0, (robot,)) for k, robot in enumerate(robots)])
    text = file.read_text()
    for old, new in edits:
        assert old in text
        text = text.replace(old, new, 1)
    file.write_text(text)
    with pytest.raises(UnreadableFileError) as told:
        read_rows(file, 4)
    return str(told.value).replace(str(file), "rows.csv")


def test_edited_rows_are_told_with_file_and_line(tmp_path: Path) -> None:
    file = tmp_path / "rows.csv"
    line = "2,success,,20,2.0,5.0,4.0,0.25,,,,,,,,,,,,,robot_0,4.0,1.0,False,30.0\n"
    why = "a row before it is missing, or this one is there twice"
    assert edited(file, (line, "")) == f"rows.csv:4 is no row of an episode: level must be 2, got 3: {why}"
    assert edited(file, (line, line + line)) == "rows.csv:5 is no row of an episode: 'robot_0' has two rows in level 2"
    assert edited(file, ("\n2,", "\n7,")) == f"rows.csv:4 is no row of an episode: level must be 2, got 7: {why}"
    last = "3,collision,obstacle,7,0.7,1.0,inf,0.0,,,,,,,,,,,,,robot_0,4.0,1.0,False,30.0\n"
    told = "rows.csv is no table of episodes: its rows must be those of 4 levels, got 3"
    assert edited(file, (last, "")) == told
    assert edited(file, ("\n2,", "\n-2,")) == "rows.csv:4 is no row of an episode: level must be a number >= 0, got -2"
    told = (
        "rows.csv:3 is no row of an episode: outcome must be one of success, collision, timeout, left_world, deadlock, "
        "misplaced, "
    )
    assert edited(file, (",collision,", ",crash,")) == f"{told}got 'crash'"
    assert (
        edited(file, (",2.0,5.0,", ",two,5.0,"))
        == "rows.csv:2 is no row of an episode: time must be a number, got 'two'"
    )
    assert edited(file, (",2.0,5.0,", ",2.0,")).startswith(
        "rows.csv:2 is no row of an episode: a row must have 25 cells"
    )
    assert (
        edited(file, ("outcome", "outcom")) == "rows.csv:1 is no table of episodes: no column outcome of this version"
    )
