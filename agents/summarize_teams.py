"""Put the results of several training seeds of a team into one JSON file, one picture and the tables of README.md.

    cd runs/circle_swap
    for n in 4 8; do irsim-gym evaluate circle_swap seed_* --team --set n_robots=$n --out test_$n; done
    cd ../..
    python agents/summarize_teams.py circle_swap runs/circle_swap/seed_* --test runs/circle_swap/test_[48]

writes results/circle_swap.json and .png beside this file, copies the policies to policies/, and prints a table for each
test. The tests may differ in the values of the scenario's parameters; each has to hold all the runs.
"""

from __future__ import annotations

import argparse
import json
import shutil
from pathlib import Path
from statistics import median
from typing import Any

from summarize import HERE, draw, percent

HEAD = (
    "| policy | CSR % [95 % interval] | ISR % | collided % | timeout % | deadlocked % | makespan s "
    "| extra time s, 50/75/90 % | SPL |"
)


def label(conditions: dict[str, Any], every: list[dict[str, Any]]) -> str:
    """Return what tells a test from the others: the parameters that differ between them, or all of a single one."""
    own = conditions["parameters"]
    differing = [name for name in own if len({str(other["parameters"].get(name)) for other in every}) > 1]
    return ", ".join(f"{name}={own[name]}" for name in differing or own) or conditions["scenario"]


def read_seed(run: Path, tests: dict[str, Any]) -> dict[str, Any]:
    """Return what one run came to: its curve, and its row in each test."""
    config, curve = (json.loads((run / file).read_text()) for file in ("config.json", "curve.json"))
    last = curve["points"][-1]
    return {
        "run": run.name,
        "settings": config["settings"],
        "machine": config["machine"],
        **{name: last[name] for name in ("training_seconds", "cpu_seconds", "steps")},
        "seconds_to": curve["seconds_to"],
        "dev_success": last["success"],
        "test": {name: row_of(run.name, test) for name, test in tests.items()},
        "curve": curve["points"],
    }


def row_of(policy: str, test: dict[str, Any]) -> dict[str, Any]:
    """Return the figures of a policy in a test."""
    found = [row for row in test["policies"] if row["policy"] == policy]
    if not found:
        raise SystemExit(f"'{policy}' is not among the policies of the test on {test['conditions']['parameters']}")
    return found[0]


def medians(seeds: list[dict[str, Any]], name: str, key: str) -> float:
    """Return the median over seeds of a rate in a test."""
    return median(seed["test"][name][key]["value"] for seed in seeds)


def table(rows: list[dict[str, Any]]) -> list[str]:
    """Return the lines of a table, one for each policy."""
    return [HEAD, "|" + "---|" * (HEAD.count("|") - 1), *map(_line, rows)]


def _line(row: dict[str, Any]) -> str:
    shares = [row[name]["value"] for name in ("individual_success", "collision", "timeout", "deadlocked")]
    times = [row["extra_time"][name] for name in ("p50", "p75", "p90")]
    extra = "-" if None in times else "/".join(f"{time:.1f}" for time in times)
    cells = [row["policy"], percent(row["cooperative_success"]), *(f"{100 * share:.1f}" for share in shares)]
    return f"| {' | '.join(cells)} | {row['makespan']:.1f} | {extra} | {row['spl']:.3f} |"


def main() -> None:
    """Read the runs and the tests, and write the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario")
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("--test", required=True, nargs="+", type=Path, help="folders of `irsim-gym evaluate --team`")
    parser.add_argument("--name", help="of the files that are written (default: the scenario)")
    parser.add_argument("--out", type=Path, default=HERE, help="where results/ and policies/ are (default: here)")
    asked = parser.parse_args()
    found = [json.loads((folder / "summary.json").read_text()) for folder in asked.test]
    every = [test["conditions"] for test in found]
    tests = {label(test["conditions"], every): test for test in found}
    seeds = [read_seed(run, tests) for run in asked.runs]
    names = {run.name for run in asked.runs}
    references = {name: [row for row in test["policies"] if row["policy"] not in names] for name, test in tests.items()}
    result = {
        "scenario": asked.scenario,
        "conditions": {name: test["conditions"] for name, test in tests.items()},
        "median_test_csr": {name: medians(seeds, name, "cooperative_success") for name in tests},
        "median_test_isr": {name: medians(seeds, name, "individual_success") for name in tests},
        "seeds": seeds,
        "references": references,
    }
    name = asked.name or asked.scenario
    for folder in ("results", "policies"):
        (asked.out / folder).mkdir(parents=True, exist_ok=True)
    (asked.out / "results" / f"{name}.json").write_text(json.dumps(result, indent=1) + "\n")
    title = f"{name}: {seeds[0]['settings']['algorithm'].upper()}, {len(seeds)} seeds"
    worst = 100 * min(point["success"] for seed in seeds for point in seed["curve"])
    draw(asked.out / "results" / f"{name}.png", title, seeds, "all robots arrive", max(0.0, worst // 10 * 10 - 10))
    for run in asked.runs:
        shutil.copyfile(run / "policy.zip", asked.out / "policies" / f"{name}_{run.name}.zip")
    for test in tests:
        csr = f"median CSR of the seeds {100 * result['median_test_csr'][test]:.1f} %"
        print(f"{test}: {csr}\n", *table([seed["test"][test] for seed in seeds] + references[test]), "", sep="\n")


if __name__ == "__main__":
    main()
