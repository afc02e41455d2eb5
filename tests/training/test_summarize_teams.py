"""agents/studies/summarize_teams.py on results made by hand."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

SCRIPT = Path(__file__).parents[2] / "agents" / "studies" / "summarize_teams.py"


def rate(value: float) -> dict[str, float]:
    return {"count": 0, "value": value, "low": value - 0.01, "high": value + 0.01}


def row(policy: str, csr: float) -> dict[str, Any]:
    names = ("individual_success", "collision", "timeout", "deadlocked")
    shares = {name: rate(0.25) for name in names}
    extra = {"levels": 9, "arrivals": 9, "p50": 1.0, "p75": 2.0, "p90": 3.0}
    figures = {"makespan": 12.5, "extra_time": extra, "spl": 0.5}
    return {"policy": policy, "cooperative_success": rate(csr), **shares, **figures}


def write(path: Path, data: Any) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(data))


def make_results(folder: Path) -> list[str]:
    point = {"steps": 8, "training_seconds": 2.0, "cpu_seconds": 1.0, "levels": 250, "success": 0.5}
    runs = [folder / f"seed_{i}" for i in range(3)]
    for run in runs:
        write(run / "config.json", {"settings": {"algorithm": "ppo"}, "machine": {}})
        write(run / "curve.json", {"seconds_to": {"95%": 1.5, "98%": None}, "points": [point]})
        (run / "policy.zip").write_bytes(b"policy")
    for n, csr in ((4, (0.9, 0.7, 0.8)), (8, (0.3, 0.2, 0.1))):
        rows = [row(run.name, value) for run, value in zip(runs, csr, strict=True)]
        conditions = {"scenario": "swap", "parameters": {"n_robots": n, "jitter": 0.4}}
        write(folder / f"test_{n}" / "summary.json", {"conditions": conditions, "policies": [*rows, row("rvo", 1.0)]})
    return ["swap", *map(str, runs), "--test", str(folder / "test_4"), str(folder / "test_8"), "--out", str(folder)]


def test_medians_and_tables(tmp_path: Path) -> None:
    arguments = [sys.executable, str(SCRIPT), *make_results(tmp_path)]
    found = subprocess.run(arguments, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr
    result = json.loads((tmp_path / "results" / "swap.json").read_text())
    assert result["median_test_csr"] == {"n_robots=4": 0.8, "n_robots=8": 0.2}
    assert [seed["test"]["n_robots=8"]["cooperative_success"]["value"] for seed in result["seeds"]] == [0.3, 0.2, 0.1]
    assert [row["policy"] for row in result["references"]["n_robots=4"]] == ["rvo"]
    lines = found.stdout.splitlines()
    assert lines[0] == "n_robots=4: median CSR of the seeds 80.0 %"
    figures = "90.0 [89.0, 91.0] | 25.0 | 25.0 | 25.0 | 25.0 | 12.5 | 1.0/2.0/3.0 | 0.500"
    assert f"| seed_0 | {figures} | 1.5 | - | 2 | 1 | 8 |" in lines
    assert lines[-2].endswith("| 0.500 |  |  |  |  |  |")
    assert (tmp_path / "policies" / "swap_seed_2.zip").read_bytes() == b"policy"
    assert (tmp_path / "results" / "swap.png").read_bytes().startswith(b"\x89PNG")
