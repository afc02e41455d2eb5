"""The shipped certificates of benchmarks, and those of played levels."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.levels.certificate import Certificate, find_certificate, shipped_certificate
from irsim_gym.evaluation.levels.certify import certify
from irsim_gym.evaluation.levels.level_commands import WORLDS, write_certificate
from irsim_gym.evaluation.levels.played import PlayedLevels
from irsim_gym.evaluation.protocol.progress_bars import counting
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.suite.members import Member, shipped_suite
from irsim_gym.evaluation.suite.row_files import read_rows
from irsim_gym.evaluation.suite.suite_record import SuiteRecord, read_record
from irsim_gym.scenario import load_scenario


def certify_members(folder: Path, names: Sequence[str]) -> None:
    """Write the shipped certificates of benchmarks for the levels of a run of the suite.

    Args:
        folder: Folder of the run. Its methods are the reference policies; each must have one policy.
        names: Tiers or benchmarks of the suite; empty for all that were played.

    Raises:
        IrsimGymError: If a method has several policies, a benchmark was not played, or its levels have changed since.
    """
    record = read_record(folder)
    _check_methods(record, folder)
    for member in shipped_suite().chosen(names or list(record.members)):
        if member.name not in record.members:
            raise IrsimGymError(f"{folder} holds no rows of {member.name}: play them with `irsim-gym suite run`")
        wanted = ScenarioRequest(member.scenario, team=member.team, parameters=member.parameters)
        count = member.levels_of(record.levels)
        episodes = wanted.episodes(min(WORLDS, count))
        with counting(f"certifying {member.name}", count) as advance:
            rows = {
                record.methods[method][0]["source"]: read_rows(folder / entries[0]["file"], count)
                for method, entries in record.runs[member.name].items()
                if entries and "file" in entries[0]
            }
            made = certify(episodes, record.split, count, rows, advance)
        _check(member, made, record, folder)
        write_certificate(made, shipped_certificate(episodes.simulation.scenario))


def _check_methods(record: SuiteRecord, folder: Path) -> None:
    """Raise if a method has several policies, which would outweigh methods with one policy."""
    several = [f"{name} has {len(policies)}" for name, policies in record.methods.items() if len(policies) > 1]
    if several:
        raise IrsimGymError(
            f"{folder}: reference policies are methods of one policy, {', '.join(several)}: play the one that is to "
            "count as a method of its own, in another folder"
        )


def _check(member: Member, made: Certificate, record: SuiteRecord, folder: Path) -> None:
    played = record.members[member.name]["conditions"]["level_hash"]
    if played != made.set_hash:
        raise IrsimGymError(
            f"{folder} holds rows of {member.name} on other levels, set {played}, now {made.set_hash}: play them again"
        )


def certified_levels(member: Mapping[str, Any]) -> PlayedLevels:
    """Return the levels of a benchmark with their certificate, which may be newer than the rows.

    Args:
        member: The benchmark's entry in the record of a run.
    """
    of = member["conditions"]
    count, digest = of["levels"], of["level_hash"]
    try:
        scenario = load_scenario(member["scenario"], member["parameters"], warn=False)
    except IrsimGymError:  # rows of an earlier version whose scenario had other parameters
        return PlayedLevels(count, digest, of["level_file"] or "", None)
    found = find_certificate(scenario, of["agents"], of["split"], digest, count)
    return PlayedLevels(count, digest, of["level_file"] or "", found)
