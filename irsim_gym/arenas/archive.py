"""The folder of an arena, and how an interrupted arena is resumed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from irsim_gym.arenas.board import Row
from irsim_gym.errors import IrsimGymError, UnreadableFileError
from irsim_gym.evaluation.tables import check_levels, plain, read_episodes, write_json
from irsim_gym.evaluation.team_tables import read_agents, write_levels, write_rows
from irsim_gym.outside_files import json_object, reading, remove
from irsim_gym.scenario.messages import show

SUMMARY, EPISODES, LEVELS, TABLE, PAGE = "summary.json", "episodes.csv", "levels.csv", "table.txt", "arena.html"
ARENA = "summary of an arena that could be resumed"
PARTS = "parts"
"""Folder with the rows of finished policies while others still play."""


@dataclass
class Archive:
    """The folder of an arena.

    Attributes:
        folder: The folder.
        team: Whether rows are of agents of teams.
        limit: The time limit [s].
        levels: Number of levels that each policy plays.
        rows: Rows of the finished policies, rounded as they are on disk.
    """

    folder: Path
    team: bool
    limit: float
    levels: int = 0
    rows: dict[str, list[Any]] = field(default_factory=dict)

    def begin(self, told: Mapping[str, object]) -> None:
        """Write the description of the arena, and remove the files of an earlier one."""
        self.folder.mkdir(parents=True, exist_ok=True)
        for name in (EPISODES, LEVELS, TABLE, PAGE, PARTS):
            remove(self.folder / name)
        write_json(self.folder / SUMMARY, {"finished": False, "arena": told})

    def go_on(self, told: Mapping[str, Any]) -> None:
        """Resume the arena in the folder: keep the rows of finished policies, except of those that have no source.

        Raises:
            IrsimGymError: If the folder holds no arena, or an arena with other levels or policies.
        """
        before = self.told()
        with reading(self.folder / SUMMARY, ARENA):
            found = _differences(before, plain(told))
        if found:
            raise IrsimGymError(
                f"{self.folder} holds an arena that is not this one, so that it cannot be resumed: {'; '.join(found)}"
            )
        if (self.folder / PARTS).is_symlink():  # nothing is written or removed behind a link
            remove(self.folder / PARTS)
        known = [self.folder / EPISODES] if (self.folder / EPISODES).is_file() else []
        for path in (*known, *self._parts()):
            self.rows |= self._read(path)
        lasting = {policy["name"] for policy in told["policies"] if policy["source"] is not None}
        self.rows = {name: rows for name, rows in self.rows.items() if name in lasting}
        write_json(self.folder / SUMMARY, {"finished": False, "arena": told})

    def told(self) -> dict[str, Any]:
        """Return the description of the arena in the folder.

        Raises:
            IrsimGymError: If the folder holds no arena.
        """
        with reading(self.folder / SUMMARY, ARENA):
            told: dict[str, Any] = json_object(self.folder / SUMMARY)["arena"]
            if not all(isinstance(policy["name"], str) and "source" in policy for policy in told["policies"]):
                raise ValueError("each of its policies must have a name and a source")
        return told

    def keep(self, name: str, rows: Sequence[Row]) -> None:
        """Write the rows of a finished policy."""
        path = self.folder / PARTS / f"{len(self._parts()):04d}.csv"
        write_rows(path, {name: rows})
        self.rows |= self._read(path)

    def finish(self, names: Sequence[str], summary: Mapping[str, object]) -> None:
        """Write the rows of all policies as one file, and the summary."""
        self.rows = {name: self.rows[name] for name in names}
        write_rows(self.folder / EPISODES, self.rows)
        if self.team:
            write_levels(self.folder / LEVELS, self.rows)
        write_json(self.folder / SUMMARY, {"finished": True, **summary})
        for path in self._parts():
            path.unlink()
        if (self.folder / PARTS).is_dir():
            (self.folder / PARTS).rmdir()

    def _parts(self) -> list[Path]:
        return sorted((self.folder / PARTS).glob("[0-9]*.csv"))

    def _read(self, path: Path) -> dict[str, list[Any]]:
        rows: dict[str, list[Any]] = {}
        rows |= read_agents(path, self.limit) if self.team else read_episodes(path)
        check_levels(path, rows, self.levels)
        return rows


def holds_arena(folder: Path) -> bool:
    """Return whether an arena has begun in a folder."""
    try:
        with reading(folder / SUMMARY, ARENA):
            return "arena" in json_object(folder / SUMMARY)
    except UnreadableFileError:
        return False


def _differences(before: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Return the differences between two arenas; further policies, or other paths of the same files, are none."""
    keys = [key for key in dict.fromkeys([*before, *now]) if key not in ("policies", "source", "task")]
    found = [
        f"{key} {show(before.get(key))}, asked for: {show(now.get(key))}"
        for key in keys
        if before.get(key) != now.get(key)
    ]
    new = {policy["name"]: policy for policy in now["policies"]}
    for policy in before["policies"]:
        if policy["name"] in new and _is_other(policy, new[policy["name"]]):
            was, now_is = (f"{each['source']} (sha256 {each['sha256']})" for each in (policy, new[policy["name"]]))
            found.append(f"policy {policy['name']} {was}, asked for: {now_is}")
    return found


def _is_other(before: Mapping[str, object], now: Mapping[str, object]) -> bool:
    """Return whether two entries of a policy differ in a key that both have."""
    return any(before[key] != value for key, value in now.items() if key in before)
