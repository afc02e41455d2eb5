"""Files with results of trained policies: those of ``irsim-gym evaluate`` and of ``agents/summarize*.py``."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from irsim_gym.base.outside_files import json_object, reading
from irsim_gym.evaluation.policies.reference_policies import is_named_policy
from irsim_gym.evaluation.saved_policies.cards import CardResult
from irsim_gym.evaluation.saved_policies.checkpoint_files import POLICY

Rows = list[dict[str, Any]]


@dataclass(frozen=True)
class SeedResults:
    """Results of one seed of a training.

    Attributes:
        result: Results on a set of levels.
        run: Settings, machine and cost of the training; None if the file does not contain them.
        seeds: All seeds of the training whose settings the file contains.
    """

    result: CardResult
    run: dict[str, Any] | None
    seeds: tuple[int, ...]


def read_results(file: Path, policy: Path) -> list[SeedResults]:
    """Return the results of a policy from a file, an entry for each set of levels.

    Args:
        file: ``summary.json`` of ``irsim-gym evaluate``, or a file of ``agents/studies/summarize.py`` or
            ``agents/studies/summarize_teams.py``.
        policy: Folder of the run, or file of the policy. Its row has the name of the folder or file, or the end of that
            name: ``seed_1`` for ``cluttered_room_seed_1.zip``.

    Raises:
        UnreadableFileError: If the file is of another kind, or has no results of the policy.
    """
    with reading(file, "file with figures of policies"):
        data = json_object(file)
        tests = list(_tests(data))
        seeds = data.get("seeds", [])
        runs = {seed["run"]: seed for seed in seeds}
        results = [_result(file, rows, conditions, _own(rows, policy)) for conditions, rows in tests]
        numbers = tuple(int(seed["settings"]["seed"]) for seed in seeds)
    return [SeedResults(result, runs.get(name), numbers) for name, result in results]


def _tests(data: Mapping[str, Any]) -> Iterator[tuple[dict[str, Any], Rows]]:
    """Yield the conditions of each test, and its rows without those of reference policies."""
    conditions = data["conditions"]
    if "seeds" not in data:
        yield conditions, [row for row in data["policies"] if not is_named_policy(row["policy"])]
    elif "split" in conditions:
        yield conditions, [seed["test"] for seed in data["seeds"]]
    else:
        for label, chosen in conditions.items():
            yield chosen, [seed["test"][label] for seed in data["seeds"]]


def _own(rows: Rows, policy: Path) -> dict[str, Any]:
    """Return the row of a policy."""
    called = policy.parent.name if policy.name == POLICY else policy.stem if policy.is_file() else policy.name
    matches = [row for row in rows if called == row["policy"] or called.endswith(f"_{row['policy']}")]
    if len(matches) != 1:
        names = ", ".join(row["policy"] for row in rows)
        raise ValueError(f"it has no row of its own for '{called}'; there are {names}")
    return matches[0]


def _result(file: Path, rows: Rows, conditions: Mapping[str, Any], row: Mapping[str, Any]) -> tuple[str, CardResult]:
    is_team = "cooperative_success" in row
    key = "cooperative_success" if is_team else "success"
    return row["policy"], CardResult(
        split=conditions["split"],
        levels=conditions["levels"],
        level_hash=conditions.get("level_hash"),
        parameters=conditions["parameters"],
        team=is_team,
        success=row[key],
        individual_success=row.get("individual_success"),
        collision=row["collision"]["value"],
        timeout=row["timeout"]["value"],
        spl=row["spl"],
        seeds={row["policy"]: row[key]["value"] for row in rows} if len(rows) > 1 else {},
        source=file.name,
        scenario=conditions.get("scenario"),
    )
