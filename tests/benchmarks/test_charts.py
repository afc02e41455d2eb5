"""The pages and the charts come from committed results alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import charts
import pictures
import pytest
import tables
from targets import TARGETS


def result(figures: dict[str, dict[str, float]], **more: Any) -> dict[str, Any]:
    machine = {
        "processor": "one",
        "cores": 2,
        "python": "3.11.0",
        "versions": {"numpy": "2.0"},
        "load": 0.25,
        "commit": "0123456789abcdef",
        "date": "2026-01-02T03:04:05+00:00",
    }
    return {"machine": machine, "results": figures, "noise": {}, **more}


@pytest.fixture
def found() -> charts.Found:
    cases = {
        "s1/faces": {"single_us": 5.0, "core_1_worlds_us": 4.0, "core_64_worlds_us": 1.0},
        "s1/twin": {"twin_64_worlds_us": 0.5},
        "growth/agents": {"10_agents_us": 1.0, "100_agents_us": 1.5, "10000_agents_us": 3.0},
        "phases/s1": {
            "64_worlds_sense_us": 0.75,
            "64_worlds_pay_us": 0.25,
            "64_worlds_whole_us": 1.0,
            "64_worlds_fused_us": 0.5,
        },
    }
    beside = {"s1_single": {"ours_us": 4.0, "ours_median_us": 5.0, "irsim_us": 900.0, "irsim_median_us": 1000.0}}
    beside["s1_single"]["irsim_times_slower"] = 200.0
    beside["s2_rvo"] = {"irsim_apart_m": 2e-15}
    rounds = {
        "ours": {"played": 7, "rejected": 0, "disturbed": 0, "calibration_us": 1000.0},
        "irsim": {"played": 12, "rejected": 5, "disturbed": 2, "calibration_us": 1100.0},
    }
    who = {
        "ours": {"package": "irsim_gym", "version": "1", "works": {"s1_single": []}},
        "irsim": {"package": "ir-sim", "version": "2.12.0", "works": {"s1_single": ["circles have corners"]}},
        "vmas": {"package": "vmas", "version": None, "works": {}, "missing": "no wheel"},
    }
    return {
        "cases.json": result(cases),
        "peers.json": result(beside, peers=who, rounds={"s1_single": rounds}),
        "old.json": result({"a": {"b_s": 1}}),
    }


def test_pages_are_what_the_results_say() -> None:
    found = charts.load()
    for file, written in ((charts.README, charts.text(found)), (charts.FRONT, charts.front(found))):
        before = file.read_text(encoding="utf-8")
        assert charts.page(written, before) == before


def test_what_stands_outside_of_the_marks_stays() -> None:
    page = charts.page("new", f"above\n{charts.BEGIN}\nold\n{charts.END}\nbelow\n")
    assert page == f"above\n{charts.BEGIN}\n\nnew\n\n{charts.END}\nbelow\n"


def test_the_first_page_tells_how_many_times_longer_others_take(found: charts.Found) -> None:
    head, _, row = charts.front(found).split("\n")
    assert head == "| a step of | us | IR-SIM, times | VMAS, times | JaxNav, times | navground, times |"
    assert row == "| one robot, 180 beams, 10 obstacles, as a `gymnasium.Env` | 5 | 200 |  |  |  |"
    assert charts.front({}) == ""


def test_charts_are_drawn_for_what_was_measured(found: charts.Found, tmp_path: Path) -> None:
    drawn = pictures.draw(found, tmp_path / "charts")
    assert sorted(file.name for file in drawn) == ["growth.png", "peers.png", "phases.png"]
    assert all(file.read_bytes().startswith(b"\x89PNG") for file in drawn)
    assert pictures.draw({"old.json": found["old.json"]}, tmp_path / "none") == []


def test_a_chart_shows_each_phase_as_its_share(found: charts.Found) -> None:
    (panel,) = pictures.phases(found["cases.json"]["results"]).axes
    assert [bar.get_width() for bar in panel.patches] == [0.75, 0.25]
    assert [text.get_text() for text in panel.texts] == ["1 us plain, 0.5 us fused"]


def test_bars_are_agent_steps_per_second_of_the_median(found: charts.Found) -> None:
    (panel,) = pictures.rates(found["peers.json"]["results"]).axes
    assert [bar.get_width() for bar in panel.patches] == [1e6 / 1000.0, 1e6 / 5.0]


def test_curves_have_the_sizes_in_their_names(found: charts.Found) -> None:
    figures = found["cases.json"]["results"]
    assert pictures.sized(figures["growth/agents"], "agents", "") == {10: 1.0, 100: 1.5, 10000: 3.0}
    assert pictures.sized(figures["s1/faces"], "worlds", "core") == {1: 4.0, 64: 1.0}


def test_growth_shows_navground_and_threads_where_there_are_figures(found: charts.Found) -> None:
    figures = found["cases.json"]["results"]
    figures["growth/threads"] = {"s1_64_worlds_1_threads_wall_us": 4.0, "s1_64_worlds_2_threads_wall_us": 2.5}
    chart = pictures.growth(figures, {"orca_100": {"navground_us": 9.0}, "s2_orca": {"irsim_us": 1.0}})
    drawn = {line.get_label(): line.get_xydata().tolist() for panel in chart.axes for line in panel.lines}
    assert drawn["navground"] == [[100.0, 9.0]]
    assert drawn["s1, 64 worlds"] == [[1.0, 4.0], [2.0, 2.5]]
    assert drawn["C twin"] == [[64.0, 0.5]]


def test_figures_with_sizes_become_a_table_of_sizes() -> None:
    text = tables.pivot(
        {"core_1_worlds_us": 4.0, "vec_env_1_worlds_us": 5.5, "core_4096_worlds_us": 1.0, "level_us": 7.0}
    )
    assert text.splitlines() == [
        "|  | core_us | vec_env_us |",
        "| --- | --- | --- |",
        "| 1 world | 4 | 5.5 |",
        "| 4,096 worlds | 1 |  |",
        "",
        "| figure | value |",
        "| --- | --- |",
        "| level_us | 7 |",
    ]


def test_the_page_says_who_did_what(found: charts.Found) -> None:
    text = charts.text(found)
    assert "| s1_single | irsim | 900 | 1,000 | 200 |" in text
    assert "- ir-sim 2.12.0, `s1_single`: circles have corners." in text
    assert "- vmas is missing: no wheel." in text
    assert "19 rounds were run; 5 were rejected as disturbed, 2 kept although disturbed" in text
    assert "calibrating loop was 1000 to 1100 us" in " ".join(text.split())
    assert "`s2_rvo`: irsim's robots end at most 2e-15 m from ours." in text
    assert f"| {TARGETS[0].text} | 200 | 150 | 500 | reached |" in text
    assert "| ORCA, an agent of 10,000 over one of 100 | 2 | 1.5 | 1.1 | **missed** |" in text
    assert "## Old" in text


@pytest.mark.parametrize(("value", "text"), [(None, ""), (0.4346, "0.435"), (999.4, "999"), (28636.4, "28,636")])
def test_numbers_have_three_digits(value: float | None, text: str) -> None:
    assert tables.number(value) == text


def test_pictures_are_compared_with_ours() -> None:
    figures = {"raster_frame_ms": 0.5, "naive_frame_ms": 100.0, "naive_times_slower": 41.0}
    rows = tables.drawing(figures).splitlines()[2:]
    assert [row.split(" | ")[1:] for row in rows] == [["0.5", "1 |"], ["100", "200 |"]]
    cases = {"cases.json": result({"frames/everything": figures})}
    assert "## Pictures" in charts.text(cases)
