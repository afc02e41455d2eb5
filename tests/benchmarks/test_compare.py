"""What counts as a change between two results, by hand."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import compare
import pytest
from compare import Change
from targets import TARGETS, Target, table


def result(figures: dict[str, float], noise: dict[str, float] | None = None) -> dict[str, Any]:
    machine = {"processor": "one", "cores": 2, "python": "3.11.0"}
    return {"machine": machine, "results": {"case": figures}, "noise": {"case": noise or {}}}


def change(figure: str, before: float, after: float, noises: tuple[float, float] = (0.0, 0.0)) -> Change:
    pair = [
        result({figure: value}, {figure: noise}) for value, noise in zip((before, after), noises, strict=True)
    ]  # fmt: skip
    (found,) = compare.compare(*pair)
    return found


def test_more_time_is_worse_and_less_is_better() -> None:
    assert change("step_us", 1.0, 1.10).verdict == "worse"
    assert change("step_us", 1.0, 0.90).verdict == "better"
    assert change("step_us", 1.0, 1.04).verdict == "same"


def test_more_frames_are_better() -> None:
    assert change("rate_per_cpu_s", 100.0, 120.0).verdict == "better"
    assert change("irsim_times_slower", 500.0, 400.0).verdict == "worse"


def test_ratios_are_judged_alike_up_and_down() -> None:
    # 1 / 1.05 = 0.952...: twice as fast and half as fast count alike.
    assert change("step_us", 1.0, 0.953).verdict == "same"
    assert change("step_us", 1.0, 0.951).verdict == "better"
    assert change("step_us", 2.0, 1.0).ratio == 0.5


def test_noise_of_either_result_widens_what_counts_as_the_same() -> None:
    assert change("step_us", 1.0, 1.2).verdict == "worse"
    assert change("step_us", 1.0, 1.2, noises=(0.0, 0.1)).verdict == "same"
    assert change("step_us", 1.0, 1.2, noises=(0.1, 0.0)).threshold == pytest.approx(0.3)
    assert change("step_us", 1.0, 1.4, noises=(0.1, 0.02)).verdict == "worse"


def test_figures_that_come_and_go_are_named() -> None:
    found = {c.figure: c.verdict for c in compare.compare(result({"a_us": 1.0}), result({"b_us": 2.0}))}
    assert found == {"a_us": "gone", "b_us": "new"}


def test_what_describes_the_run_is_not_judged() -> None:
    assert list(compare.compare(result({"steps": 100.0}), result({"steps": 500.0}))) == []


def test_other_machines_are_told() -> None:
    other = result({})
    other["machine"]["cores"] = 8
    assert compare.machines_differ(result({}), other) == ["cores: 2 and 8"]
    assert compare.machines_differ(result({}), result({})) == []


@pytest.mark.parametrize(("after", "status"), [(1.5, 1), (0.5, 0), (1.0, 0)])
def test_the_exit_status_says_whether_anything_got_worse(
    after: float, status: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = [tmp_path / "before.json", tmp_path / "after.json"]
    for file, value in zip(files, (1.0, after), strict=True):
        file.write_text(json.dumps(result({"step_us": value})))
    monkeypatch.setattr(sys, "argv", ["compare.py", *map(str, files)])
    assert compare.main() == status
    monkeypatch.setattr(sys, "argv", ["compare.py", *map(str, files), "-f", "nothing"])
    assert compare.main() == 0


def test_a_target_is_a_ratio_that_should_be_large_or_small() -> None:
    faster = Target("times faster", "case", "theirs_us", "ours_us", least=100, aim=500)
    verdicts = [faster.verdict({"case": {"theirs_us": us, "ours_us": 2.0}}) for us in (100.0, 200.0, 1000.0)]
    assert verdicts == ["missed", "reached", "aim"]
    small = Target("seconds", "case", "first_s", "", least=15, aim=8)
    assert [small.verdict({"case": {"first_s": s}}) for s in (20.0, 15.0, 8.0)] == ["missed", "reached", "aim"]
    assert small.verdict({}) == "not measured"
    assert faster.value({"case": {"theirs_us": 1.0}}) is None


def test_the_table_of_targets_has_a_row_for_each() -> None:
    rows = table({"memory": {"s1_world_kib": 6.5}})
    assert len(rows) == len(TARGETS)
    told = {row["text"]: row["verdict"] for row in rows}
    assert told["Memory of a world of S1 [KiB]"] == "aim"
    assert set(told.values()) == {"aim", "not measured"}
