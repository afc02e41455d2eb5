"""The record of a run of the suite: its settings, its scenarios, and what has been played."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.outside_files import checked, json_object, reading
from irsim_gym.evaluation.protocol.tables import write_json
from irsim_gym.evaluation.requests.machine import machine
from irsim_gym.evaluation.requests.methods import ComparedMethod
from irsim_gym.evaluation.saved_policies.snapshot import take_snapshot
from irsim_gym.evaluation.suite.members import Member

SUMMARY = "summary.json"
ROWS = "rows"
RECORD = "summary of a run of the suite"


@dataclass
class SuiteRecord:
    """The content of ``summary.json`` of a run of the suite.

    Attributes:
        split: Split of the levels.
        levels: Number of levels of each benchmark, from level 0.
        members: Each benchmark with the hash of its scenario and the conditions of its figures.
        methods: The policies of each method, with hashes of their files.
        runs: By benchmark and method, an entry for each policy: the file of its rows, or why it was left out.
        figures: Figures by benchmark and method, see ``scores``.
        overall: Figures over all benchmarks, by method.
        machine: Processor and versions of the last run.
    """

    split: str
    levels: int
    members: dict[str, dict[str, Any]] = field(default_factory=dict)
    methods: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    runs: dict[str, dict[str, list[dict[str, Any]]]] = field(default_factory=dict)
    figures: dict[str, dict[str, Any]] = field(default_factory=dict)
    overall: dict[str, Any] = field(default_factory=dict)
    machine: dict[str, Any] = field(default_factory=machine)

    def write(self, folder: Path) -> None:
        """Write the record into the folder."""
        write_json(folder / SUMMARY, asdict(self))

    def done(self, member: str, method: str) -> list[dict[str, Any]]:
        """Return the entries of a method's policies on a benchmark, which callers append to."""
        return self.runs.setdefault(member, {}).setdefault(method, [])

    def played(self, member: str) -> int:
        """Return the number of levels of a benchmark that were played."""
        return int(self.members[member]["conditions"]["levels"])

    def add(self, members: Sequence[Member], methods: Sequence[ComparedMethod]) -> None:
        """Add benchmarks and methods that are about to be played.

        Raises:
            IrsimGymError: If policies or scenarios have changed since their rows were played.
        """
        changed = [
            *_note(self.methods, {method.name: method.identity() for method in methods}, "the policies of"),
            *_note(self.members, {member.name: _scenario(member) for member in members}, "the scenario of"),
        ]
        if changed:
            raise IrsimGymError(
                f"{'; '.join(changed)} changed since rows were played: choose another folder with --out, or replace "
                "all of them with --overwrite"
            )


def read_record(folder: Path) -> SuiteRecord:
    """Return the record in a folder.

    Raises:
        IrsimGymError: If the folder holds no run of the suite.
    """
    path = folder / SUMMARY
    if not path.is_file():
        raise IrsimGymError(f"{folder} holds no run of the suite (no {SUMMARY}); `irsim-gym suite run` makes one")
    with reading(path, RECORD):
        record = checked(SuiteRecord(**json_object(path)))
        for member, methods in record.runs.items():
            places = [(entry, entry.get("left_out", entry.get("file"))) for each in methods.values() for entry in each]
            if not all(isinstance(place, str) for _, place in places):
                raise ValueError(f"runs.{member}: each entry must have a file, or say why it was left_out")
            if any("file" in entry for entry, _ in places):
                record.played(member)
    return record


def _note(known: dict[str, Any], now: Mapping[str, Any], what: str) -> list[str]:
    """Add new entries; return the names of known entries that differ."""
    changed = []
    for name, entry in now.items():
        before = known.setdefault(name, entry)
        same = before == entry if isinstance(entry, list) else all(before.get(key) == entry[key] for key in entry)
        if not same:
            changed.append(f"{what} {name}")
    return changed


def _scenario(member: Member) -> dict[str, object]:
    digest = take_snapshot(member.scenario, None, member.parameters).digest
    own = {"scenario": member.scenario, "parameters": dict(member.parameters), "team": member.team}
    more = {"disturbed": member.disturbances[0]} if member.disturbed else {}
    return {**own, **more, "differs": member.differs, "sha256": digest}
