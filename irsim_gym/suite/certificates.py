"""The certificates that are shipped with the benchmarks."""

from __future__ import annotations

from collections.abc import Sequence

from irsim_gym.levels.certificate import shipped_certificate
from irsim_gym.suite.members import shipped_suite
from irsim_gym.training.level_commands import WORLDS, Wanted, certified, write_certificate


def certify_members(names: Sequence[str], count: int, policies: Sequence[str] | None) -> None:
    """Write the shipped certificates of benchmarks, for their ``test`` levels.

    Args:
        names: Tiers or single benchmarks of the suite.
        count: How many levels, of benchmarks that have so many.
        policies: The reference policies, as ``load_policy`` takes them; None for those that fit.
    """
    for member in shipped_suite().chosen(names):
        wanted = Wanted(member.scenario, team=member.team, parameters=member.parameters)
        n_levels = min(count, member.levels or count)
        episodes = wanted.episodes(min(WORLDS, n_levels))
        made = certified(episodes, "test", n_levels, policies)
        write_certificate(made, shipped_certificate(episodes.simulation.scenario))
