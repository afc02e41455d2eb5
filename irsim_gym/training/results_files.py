"""Figures of trained policies in files: of ``irsim-gym evaluate`` and of ``agents/summarize*.py``."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.reference_policies import is_named_policy
from irsim_gym.training.cards import CardResult
from irsim_gym.training.checkpoint_files import POLICY

Rows = list[dict[str, Any]]


@dataclass(frozen=True)
class SeedResults:
    """What a file says of one seed of a training.

    Attributes:
        result: Its figures on some levels.
        run: Settings, machine and cost of its training, where the file has them.
        seeds: Seeds of the same training that the file knows the settings of.
    """

    result: CardResult
    run: dict[str, Any] | None
    seeds: tuple[int, ...]


def read_results(file: Path, policy: Path) -> list[SeedResults]:
    """Return what a file says of a policy, an entry for each set of levels.

    Args:
        file: ``summary.json`` of ``irsim-gym evaluate``, or what ``agents/summarize.py`` or ``summarize_teams.py`` has
            written.
        policy: The policy's run folder or file. Its row is the one with the name of the folder or file, or with the
            end of that name: ``seed_1`` for ``cluttered_room_seed_1.zip``.

    Raises:
        IrsimGymError: The file says nothing of it, or is none of these.
    """
    try:
        data = json.loads(file.read_text(encoding="utf-8"))
        tests = list(_tests(data))
        seeds = data.get("seeds", [])
        runs = {seed["run"]: seed for seed in seeds}
        found = [_result(file, rows, conditions, _own(file, rows, policy)) for conditions, rows in tests]
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise IrsimGymError(f"{file} holds no figures of policies: {type(error).__name__} {error}") from error
    numbers = tuple(int(seed["settings"]["seed"]) for seed in seeds)
    return [SeedResults(result, runs.get(name), numbers) for name, result in found]


def _tests(data: Mapping[str, Any]) -> Iterator[tuple[dict[str, Any], Rows]]:
    """Yield the conditions of each test, and its rows but for the references'."""
    conditions = data["conditions"]
    if "seeds" not in data:
        yield conditions, [row for row in data["policies"] if not is_named_policy(row["policy"])]
    elif "split" in conditions:
        yield conditions, [seed["test"] for seed in data["seeds"]]
    else:
        for label, own in conditions.items():
            yield own, [seed["test"][label] for seed in data["seeds"]]


def _own(file: Path, rows: Rows, policy: Path) -> dict[str, Any]:
    """Return the row of a policy."""
    called = policy.parent.name if policy.name == POLICY else policy.stem if policy.is_file() else policy.name
    own = [row for row in rows if called == row["policy"] or called.endswith(f"_{row['policy']}")]
    if len(own) != 1:
        names = ", ".join(row["policy"] for row in rows)
        raise IrsimGymError(f"{file} has no row of its own for '{called}'; there are {names}")
    return own[0]


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
        seeds={one["policy"]: one[key]["value"] for one in rows} if len(rows) > 1 else {},
        source=file.name,
        scenario=conditions.get("scenario"),
    )
