import csv
import json
from pathlib import Path

from irsim_gym.evaluation.measures.metrics import EpisodeRow
from irsim_gym.evaluation.measures.team_metrics import AgentRow, TeamRow, summarize_team, summarize_teams
from irsim_gym.evaluation.protocol.figure_columns import summary_table
from irsim_gym.evaluation.protocol.tables import legend, table_text, write_json
from irsim_gym.evaluation.protocol.team_tables import compared_table, write_agents, write_levels


def agent(name: str, level: int, outcome: str, time: float, hit: str = "") -> AgentRow:
    return AgentRow(name, EpisodeRow(level, outcome, hit, round(10 * time), time, 5.0, 4.0, 0.25), 4.0, 2.0, False)


SOLVED = TeamRow(0, 20.0, (agent("ann", 0, "success", 3.0), agent("bob", 0, "success", 4.0)))
CRASHED = TeamRow(1, 20.0, (agent("ann", 1, "success", 5.0), agent("bob", 1, "collision", 2.0, "map")))
ROWS = [SOLVED, CRASHED]


def read(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def test_a_row_for_each_agent_and_level(tmp_path: Path) -> None:
    write_agents(tmp_path / "episodes.csv", {"rvo": ROWS})
    rows = read(tmp_path / "episodes.csv")
    assert [(row["policy"], row["level"], row["agent"], row["outcome"]) for row in rows] == [
        ("rvo", "0", "ann", "success"),
        ("rvo", "0", "bob", "success"),
        ("rvo", "1", "ann", "success"),
        ("rvo", "1", "bob", "collision"),
    ]
    assert (rows[0]["arrival_time"], rows[0]["extra_time"], rows[0]["spl"]) == ("3.0", "1.0", "0.8")
    assert (rows[3]["arrival_time"], rows[3]["extra_time"], rows[3]["hit"]) == ("", "", "map")
    assert rows[3]["deadlocked"] == "False"


def test_a_row_for_each_level(tmp_path: Path) -> None:
    write_levels(tmp_path / "levels.csv", {"rvo": ROWS})
    first, second = read(tmp_path / "levels.csv")
    assert (first["agents"], first["arrived"], first["success"]) == ("2", "2", "True")
    assert (first["makespan"], first["flowtime"]) == ("4.0", "7.0")
    assert (second["success"], second["makespan"], second["flowtime"], second["collided"]) == (
        "False",
        "20.0",
        "25.0",
        "1",
    )


def test_the_legend_of_a_team() -> None:
    lines = legend([summary_table(summarize_teams({"rvo": ROWS}), "swap")]).splitlines()
    names = ["CSR", "ISR", "deadlocked", "SPL", "makespan", "flowtime", "extra time", "clear.", "goals /hit"]
    assert [line.split(":")[0] for line in lines] == names


def test_summary_as_json(tmp_path: Path) -> None:
    write_json(tmp_path / "summary.json", {"policies": summarize_teams({"rvo": ROWS})})
    found = json.loads((tmp_path / "summary.json").read_text())["policies"][0]
    assert (found["cooperative_success"]["count"], found["individual_success"]["count"]) == (1, 3)
    assert found["extra_time"] == {"levels": 2, "arrivals": 3, "p50": 2.0, "p75": 2.5, "p90": 2.8}
    assert found["common_extra_time"] is None


def test_table() -> None:
    text = table_text(summary_table([summarize_team("rvo", ROWS)], "swap"))
    assert text.splitlines()[0] == "swap"
    row = next(line.split() for line in text.splitlines() if "rvo" in line)
    # CSR 1 of 2; ISR 3 of 4; one collision of four, 3 goals; SPL (3 * 4/5) / 4; makespan (4 + 20) / 2; flowtime 32 / 2.
    assert [row[1], row[3], row[5], row[6]] == ["50.0", "75.0", "25.0", "3.0"]
    assert row[-5:] == ["0.600", "12.0", "16.0", "2.0/2.5/2.8", "0.250"]
    assert "with map" not in text
    assert max(map(len, text.splitlines())) <= 120


def test_table_of_levels_that_all_solved() -> None:
    assert compared_table(summarize_teams({"rvo": ROWS})) is None
    table = compared_table(summarize_teams({"rvo": ROWS, "ours": [SOLVED, CRASHED]}))
    assert table is not None
    lines = table_text(table).splitlines()
    assert lines[0] == "levels that all of these solved"
    # Extra times 3 - 4/2 and 4 - 4/2.
    assert ["ours", "1", "1.5/1.8/1.9"] in [line.split() for line in lines]
