"""docs/benchmarks.md shows the shipped reference rows, and a picture of every benchmark."""

from __future__ import annotations

import json
import re
import runpy
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from irsim_gym.evaluation.suite.listing import reference_figures
from irsim_gym.evaluation.suite.members import shipped_suite
from irsim_gym.evaluation.suite.suite_record import SuiteRecord
from irsim_gym.scenario.specs.library import references_file

DOCS = Path(__file__).parents[3] / "docs"
PAGE = DOCS / "benchmarks.md"
LARGEST_DIFFERENCE = 4.0


def test_the_tables_of_the_page_are_those_of_the_reference_rows() -> None:
    script = runpy.run_path(str(DOCS / "benchmark_page.py"))
    text = PAGE.read_text(encoding="utf-8")
    assert text.partition(script["MARK"])[2] == script["tables"]()


def test_the_rows_of_barn_are_those_of_their_file() -> None:
    record = json.loads((DOCS.parent / "agents" / "results" / "barn_dwa.json").read_text(encoding="utf-8"))
    table = PAGE.read_text(encoding="utf-8").partition("## BARN")[2].partition("\n## ")[0]
    shown = [line.split("|")[2:-1] for line in table.split("\n") if line.startswith("|")][2:]
    rows = [record["published"], *record["rows"].values()]
    assert len(shown) == len(rows)
    for cells, row in zip(shown, rows, strict=True):
        figures = [*(100 * row[key] for key in ("success", "collision", "timeout")), row["time"]]
        assert list(map(float, cells[:4])) == pytest.approx(figures, abs=0.051)
        assert float(cells[4]) == pytest.approx(row["score"], abs=0.00051)


def test_every_benchmark_has_a_picture_and_reference_rows_are_of_benchmarks() -> None:
    shown = dict(re.findall(r"!\[Levels of (.*)\]\(benchmarks/(.+)\.png\)", PAGE.read_text(encoding="utf-8")))
    members = shipped_suite().members
    assert list(shown) == list(members)
    assert {file.stem for file in (DOCS / "benchmarks").glob("*.png")} == set(shown.values())
    assert [name for name, file in shown.items() if file != name] == [n for n, m in members.items() if m.disturbed]
    assert all(members[shown[name]].scenario == member.scenario for name, member in members.items())
    assert set(reference_figures()) <= set(shown)


def test_the_picture_of_a_benchmark_is_what_its_script_draws(tmp_path: Path) -> None:
    runpy.run_path(str(DOCS / "benchmark_pictures.py"))["main"](tmp_path, ["bug_trap"])
    drawn, shown = (
        np.asarray(Image.open(folder / "bug_trap.png").convert("RGB"), np.float64)
        for folder in (tmp_path, DOCS / "benchmarks")
    )
    assert drawn.shape == shown.shape
    assert np.abs(drawn - shown).mean() < LARGEST_DIFFERENCE


def test_a_run_takes_the_place_of_the_rows_of_its_benchmarks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    take_over = runpy.run_path(str(DOCS / "benchmark_page.py"))["take_over"]
    copy = tmp_path / "references.json"
    copy.write_bytes(references_file().read_bytes())
    monkeypatch.setitem(take_over.__globals__, "references_file", lambda: copy)
    before = json.loads(copy.read_text())
    run = SuiteRecord(**json.loads(copy.read_text()))
    for rows in (run.members, run.runs, run.figures):
        rows.update({"maze": rows.pop("maze")})
        for name in set(rows) - {"maze"}:
            del rows[name]
    run.figures["maze"] = {"mine": run.figures["maze"]["dash"]}
    run.runs["maze"] = {"mine": run.runs["maze"]["dash"]}
    run.methods = {"mine": [{"source": "mine", "sha256": None}]}
    run.write(tmp_path / "run")
    take_over(tmp_path / "run")
    after = json.loads(copy.read_text())
    assert list(after["figures"]) == list(before["figures"])
    assert list(after["figures"]["maze"]) == ["mine"]
    del after["figures"]["maze"], before["figures"]["maze"]
    assert after["figures"] == before["figures"]
    assert list(after["methods"]) == [*before["methods"], "mine"]
    run.methods["late"] = run.methods["mine"]
    run.write(tmp_path / "run")
    with pytest.raises(SystemExit, match=r"is not finished, .* continues it: late in maze$"):
        take_over(tmp_path / "run")
    run.levels = 10
    run.write(tmp_path / "run")
    with pytest.raises(SystemExit, match="holds 10 test levels, not 1000 test levels"):
        take_over(tmp_path / "run")
    for rows in (run.members, run.runs, run.figures):
        rows["rooms_disturbed"] = rows.pop("maze")
    run.write(tmp_path / "run")
    with pytest.raises(SystemExit, match="holds 10 test levels, not 250 test levels"):
        take_over(tmp_path / "run")
    run.levels, late = 250, {"value": 0.31, "played_to": 0.8}
    run.methods = {"orca": run.methods["mine"]}
    run.runs["rooms_disturbed"] = {"orca": run.runs["rooms_disturbed"]["mine"]}
    run.figures["rooms_disturbed"] = {"orca": {**run.figures["rooms_disturbed"]["mine"], "latency_at_loss": late}}
    run.write(tmp_path / "run")
    take_over(tmp_path / "run")
    rooms = {method: row["latency_at_loss"] for method, row in json.loads(copy.read_text())["figures"]["rooms"].items()}
    assert rooms == {method: row.get("latency_at_loss") for method, row in before["figures"]["rooms"].items()} | {
        "orca": late
    }
