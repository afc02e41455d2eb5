"""Summaries of several seeds of a training: a JSON file, a table, and a figure of the learning curves."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from statistics import median
from typing import Any

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.outside_files import json_object, reading
from irsim_gym.evaluation.measures.statistics import interquartile_mean
from irsim_gym.evaluation.protocol.tables import write_json
from irsim_gym.evaluation.saved_policies.checkpoint_files import list_checkpoints
from irsim_gym.training.settings.run import Run

Figures = dict[str, Any]
"""A row of a ``summary.json`` of ``irsim-gym evaluate``, or the whole file, as plain data."""

MARKS = ("95%", "98%")
COSTS = ("s to 95 %", "s to 98 %", "training s", "CPU s", "steps")
WORST = "5 %"
"""Which share of the worst levels the table of one robot shows."""
HEAD = ("policy", "success % [95 % interval]", "collision %", "timeout %", "SPL", f"worst {WORST}")
TEAM_HEAD = (
    *("policy", "CSR % [95 % interval]", "ISR %", "collided %", "timeout %", "deadlocked %"),
    *("makespan s", "extra time s, 50/75/90 %", "SPL"),
)
TEAM_SHARES = ("individual_success", "collision", "timeout", "deadlocked")


def summarize_seeds(scenario: str, runs: Sequence[Path], tests: Sequence[Figures], part: str | None = None) -> Figures:
    """Return a summary of several seeds.

    Args:
        runs: Folders of the runs, with scored checkpoints.
        tests: Evaluations of all runs, whose policies are named after the runs' folders. Only teams may have several.
        part: Name of the scenario in the curves of runs in a mixture; None if there is only one scenario.

    Raises:
        IrsimGymError: If an evaluation lacks a run, or there are several evaluations of a single robot.
    """
    is_team = "cooperative_success" in tests[0]["policies"][0]
    if not is_team and len(tests) > 1:
        raise IrsimGymError(f"the seeds of a single robot need one evaluation, got {len(tests)}")
    conditions = [test["conditions"] for test in tests]
    labelled = {label(test["conditions"], conditions): test for test in tests}
    seeds = [read_seed(run, labelled, part) for run in runs]
    names = {run.name for run in runs}
    others = {
        name: [_row_of(row["policy"], test) for row in test["policies"] if row["policy"] not in names]
        for name, test in labelled.items()
    }
    if is_team:
        rates = {key: "cooperative_success" if key == "csr" else "individual_success" for key in ("csr", "isr")}
        middle: Figures = {
            f"median_test_{key}": {test: _median([seed["test"][test] for seed in seeds], name) for test in labelled}
            for key, name in rates.items()
        }
        by_test = {name: test["conditions"] for name, test in labelled.items()}
        return {"scenario": scenario, "conditions": by_test, **middle, "seeds": seeds, "references": others}
    (only,) = labelled
    seeds = [{**seed, "test": seed["test"][only]} for seed in seeds]
    rows = [seed["test"] for seed in seeds]
    return {
        "scenario": scenario,
        "conditions": conditions[0],
        "median_test_success": _median(rows, "success"),
        "interquartile_mean_test_success": asdict(interquartile_mean([[row["success"]["value"] for row in rows]])),
        "worst_of_method": _worst_of_method(tests[0]),
        "seeds": seeds,
        "references": others[only],
    }


def named_as_runs(test: Figures, runs: Sequence[Path]) -> Figures:
    """Return an evaluation of one method, whose policies are the first rows, with the names of the runs' folders."""
    rows = test["policies"]
    names = {row["policy"]: run.name for row, run in zip(rows[: len(runs)], runs, strict=True)}
    named = [{**row, "policy": names.get(row["policy"], row["policy"])} for row in rows]
    worst = {names.get(name, name): shares for name, shares in test["worst"].items()}
    return {**test, "policies": named, "worst": worst}


def _worst_of_method(test: Figures) -> Figures | None:
    """Return the success on the worst levels of the only method of several policies; None without one."""
    alone = {row["policy"] for row in test["policies"]}
    return next((shares for name, shares in test.get("worst", {}).items() if name not in alone), None)


def said_of_seeds(shares: Sequence[float], worst: Mapping[str, float] | None) -> str:
    """Return a sentence on the middle of the seeds.

    Args:
        shares: Success of each.
        worst: Success of all on the worst levels, by the share of levels; None where it is not known.
    """
    mean = interquartile_mean([[100.0 * share for share in shares]])
    interval = f" [{mean.low:.1f}, {mean.high:.1f}]" if len(shares) > 1 else ""
    middle = f"median {100.0 * median(shares):.1f} %, interquartile mean {mean.value:.1f} %{interval} over seeds"
    worst_levels = ", ".join(f"{100.0 * value:.1f} % on the worst {name}" for name, value in (worst or {}).items())
    return f"{middle}; {worst_levels}" if worst_levels else middle


def label(conditions: Figures, every: Sequence[Figures]) -> str:
    """Return the label of a test: the parameters that differ between tests, or all parameters of a single test."""
    parameters = conditions["parameters"]
    differing = [name for name in parameters if len({str(other["parameters"].get(name)) for other in every}) > 1]
    return ", ".join(f"{name}={parameters[name]}" for name in differing or parameters) or str(conditions["scenario"])


def read_seed(run: Path, tests: Mapping[str, Figures], part: str | None = None) -> Figures:
    """Return the results of a run: settings, cost, learning curve, the time to each mark, and its row in each test.

    Args:
        run: Folder of the run.
        tests: Evaluations by their labels.
        part: Name of the scenario of a mixture whose curve is wanted; None for the whole curve.

    Raises:
        IrsimGymError: If later checkpoints have no scores, so that the curve ends before the training did.
    """
    with reading(run, "folder of a run with its curve"):
        config, curve = (json_object(run / file) for file in ("config.json", "curve.json"))
    if part is not None:
        from irsim_gym.training.curves.score import scenario_point, seconds_to

        points = [scenario_point(point, part) for point in curve["points"]]
        curve = {"points": points, "seconds_to": seconds_to(points)}
    last = curve["points"][-1]
    unscored = [path for path in list_checkpoints(Run(run).checkpoints) if int(path.name) > last["steps"]]
    if unscored:
        raise IrsimGymError(
            f"{run}: {len(unscored)} checkpoint(s) after {last['steps']:,} steps have no scores; the command of the "
            "training computes them"
        )
    spent = {name: last[name] for name in ("training_seconds", "cpu_seconds", "steps")}
    about = {"run": run.name, "settings": config["settings"], "machine": config["machine"], **spent}
    tested = {name: _row_of(run.name, test) for name, test in tests.items()}
    reached = {"seconds_to": curve["seconds_to"], "dev_success": last["success"]}
    return {**about, **reached, "test": tested, "curve": curve["points"]}


def _row_of(policy: str, test: Figures) -> Figures:
    rows = [row for row in test["policies"] if row["policy"] == policy]
    if not rows:
        raise IrsimGymError(f"'{policy}' is not among the policies of the test on {test['conditions']['parameters']}")
    return {**rows[0], "worst": test["worst"][policy]} if "worst" in test else dict(rows[0])


def _median(rows: Sequence[Figures], key: str) -> float:
    return float(median(row[key]["value"] for row in rows))


def seed_cells(summary: Figures, test: str | None = None) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return the header and the rows of a table: the seeds with the cost of their training, then the references.

    Args:
        summary: Summary of ``summarize_seeds``.
        test: Label of the test of a team; None for a single robot.
    """
    seeds, others = summary["seeds"], summary["references"] if test is None else summary["references"][test]
    cells = _cells if test is None else _team_cells
    rows = [(*cells(seed["test"] if test is None else seed["test"][test]), *_costs(seed)) for seed in seeds]
    rows += [(*cells(row), *[""] * len(COSTS)) for row in others]
    return (*(HEAD if test is None else TEAM_HEAD), *COSTS), rows


def _cells(row: Figures) -> tuple[str, ...]:
    collision, timeout = (f"{100 * row[name]['value']:.1f}" for name in ("collision", "timeout"))
    worst = f"{100 * row['worst'][WORST]:.0f}" if "worst" in row else ""
    return row["policy"], percent(row["success"]), collision, timeout, f"{row['spl']:.3f}", worst


def _team_cells(row: Figures) -> tuple[str, ...]:
    shares = (f"{100 * row[name]['value']:.1f}" for name in TEAM_SHARES)
    times = [row["extra_time"][name] for name in ("p50", "p75", "p90")]
    extra = "-" if None in times else "/".join(f"{time:.1f}" for time in times)
    success = percent(row["cooperative_success"])
    return row["policy"], success, *shares, f"{row['makespan']:.1f}", extra, f"{row['spl']:.3f}"


def _costs(seed: Figures) -> tuple[str, ...]:
    marks = (seed["seconds_to"].get(mark) for mark in MARKS)
    times = ("-" if value is None else f"{value:.1f}" for value in marks)
    return *times, f"{seed['training_seconds']:.0f}", f"{seed['cpu_seconds']:.0f}", f"{seed['steps']:,}"


def percent(rate: Mapping[str, float]) -> str:
    """Return a rate with its confidence interval, in percent."""
    return f"{100 * rate['value']:.1f} [{100 * rate['low']:.1f}, {100 * rate['high']:.1f}]"


def markdown_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the lines of a Markdown table."""
    first, *others = (f"| {' | '.join(cells)} |" for cells in (head, *rows))
    return [first, "|" + "---|" * len(head), *others]


def write_seeds(folder: Path, name: str, summary: Figures, *, called: str | None = None) -> None:
    """Write ``NAME.json``, and ``NAME.png`` with the learning curves.

    Args:
        summary: Summary of ``summarize_seeds``.
        called: Name in the title of the figure; None for ``name``.
    """
    from irsim_gym.training.curves.learning_curve import draw_curves

    write_json(folder / f"{name}.json", summary)
    seeds = summary["seeds"]
    is_team = "median_test_csr" in summary
    algorithm = seeds[0]["settings"]["algorithm"].upper()
    title = f"{called or name}: {algorithm}, {len(seeds)} seed{'s' * (len(seeds) > 1)}"
    draw_curves(folder / f"{name}.png", title, seeds, "all robots arrive" if is_team else "success")
