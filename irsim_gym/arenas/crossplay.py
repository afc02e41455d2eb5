"""Cross-play: two policies that were not trained together drive the agents of one team.

In the arrangement (one, other), the first policy drives the first agent, the third and so on; the other policy drives
the rest. Both arrangements of a pair are played, so that each policy drives every agent once in every level. Paired
with itself, a policy drives all agents. This measures how well policies cooperate with partners that they were not
trained with (Hu et al. 2020, "Other-Play", arXiv:2003.02979).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from rich.table import Table

from irsim_gym.arenas.entrants import Entrant
from irsim_gym.arraytypes import Ints
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.behavior_policies import BehaviorPolicy
from irsim_gym.evaluation.metrics import Rate
from irsim_gym.evaluation.perception import Perceived, Perceives, Perception
from irsim_gym.evaluation.policy import Actions, Policy, by_agent, without_lone_axis
from irsim_gym.evaluation.tables import COMPACT, figure_table, percent
from irsim_gym.evaluation.team_metrics import TeamRow, rate_of_agents
from irsim_gym.tasks import Episodes

BETWEEN = " + "
"""Separator between the names of the two policies of an arrangement."""


class MixedPolicy:
    """Drives some agents by one policy and the others by another; both have the same observation, see ``check_mix``.

    Args:
        one: Policy of the first agent, the third and so on.
        other: Policy of the second agent, the fourth and so on.
    """

    def __init__(self, one: Policy, other: Policy, n_agents: int) -> None:
        first, second = range(0, n_agents, 2), range(1, n_agents, 2)
        self._parts = [(_of_agents(one, first), first), (_of_agents(other, second), second)]
        perceiving = (policy for policy in (one, other) if isinstance(policy, Perceives))
        self.perception: Perception | None = next((policy.perception for policy in perceiving), None)

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Notify both policies that levels begin."""
        for policy, _ in self._parts:
            policy.begin(episodes, worlds, levels)

    def act(self, episodes: Episodes, worlds: Ints) -> Actions:
        """Return the actions of worlds: for each agent, those of its policy."""
        acted: Actions | None = None
        for policy, driven in self._parts:
            chosen = by_agent(policy.act(episodes, worlds), episodes, worlds)
            acted = chosen.copy() if acted is None else acted
            acted[:, list(driven)] = chosen[:, list(driven)]
        assert acted is not None
        return without_lone_axis(acted)


def _of_agents(policy: Policy, driven: Sequence[int]) -> Policy:
    """Return a policy that drives only some agents; one that observes each agent separately needs no change."""
    return BehaviorPolicy(policy.name, driven) if isinstance(policy, BehaviorPolicy) else policy


@dataclass(frozen=True)
class Arrangement:
    """The assignment of two policies to the agents of a team.

    Attributes:
        one: Policy of the first agent, the third and so on.
        other: Policy of the second agent, the fourth and so on; may be the same policy.
    """

    one: str
    other: str

    @property
    def name(self) -> str:
        """``one + other``, or the name alone if both are the same policy."""
        return self.one if self.one == self.other else f"{self.one}{BETWEEN}{self.other}"

    def drivers(self, n_agents: int) -> list[str]:
        """Return the name of the policy of each agent."""
        return [self.other if a % 2 else self.one for a in range(n_agents)]


def arrangements(names: Sequence[str]) -> list[Arrangement]:
    """Return each policy paired with itself, then each pair in both arrangements."""
    pairs = [Arrangement(*pair) for pair in product(names, repeat=2)]
    return sorted(pairs, key=lambda pair: pair.one != pair.other)


def mixed(entrants: Sequence[Entrant], n_agents: int) -> dict[str, Policy]:
    """Return the policies of all arrangements of two different entrants.

    Raises:
        IrsimGymError: If there are fewer than two entrants or agents.
    """
    if len(entrants) < 2 or n_agents < 2:
        raise IrsimGymError(
            "--mix lets different policies drive the agents of one team: it needs two policies and two agents, got "
            f"{len(entrants)} and {n_agents}"
        )
    of = {entrant.name: entrant.policy for entrant in entrants}
    pairs = [pair for pair in arrangements(list(of)) if pair.one != pair.other]
    return {pair.name: MixedPolicy(of[pair.one], of[pair.other], n_agents) for pair in pairs}


def check_mix(entrants: Sequence[Entrant], worlds: Perceived) -> None:
    """Check that all policies have the same observation, so that any two can drive one team.

    Raises:
        IrsimGymError: If observations or actions differ.
    """
    perceiving = [entrant for entrant in entrants if isinstance(entrant.policy, Perceives)]
    if len({id(worlds.of(entrant.policy)) for entrant in perceiving}) > 1:
        told = "; ".join(
            f"{entrant.name} {', '.join(worlds.observed_by(entrant.policy) or ())}" for entrant in perceiving
        )
        raise IrsimGymError(
            f"--mix lets two policies drive one team, and these do not observe and act alike: {told}. "
            "Leave some out, or play without --mix"
        )


@dataclass(frozen=True)
class Meeting:
    """Results of a policy with a partner, in both arrangements.

    Attributes:
        policy: Name of the policy.
        partner: Name of the policy that drives the other agents; may be the policy itself.
        individual_success: Share of the policy's own agents that arrived.
        collision: Share of its own agents that collided.
        cooperative_success: Share of levels in which all agents of both arrived, over both arrangements.
    """

    policy: str
    partner: str
    individual_success: Rate
    collision: Rate
    cooperative_success: Rate


def meetings(names: Sequence[str], rows: Mapping[str, Sequence[TeamRow]]) -> list[Meeting]:
    """Return the results of each policy with each partner.

    Args:
        rows: Levels by name of the arrangement; all arrangements have the same levels.
    """
    return [_meeting(policy, partner, rows) for policy, partner in product(names, repeat=2)]


def meetings_table(meetings: Sequence[Meeting]) -> Table:
    """Lay out which share of each policy's robots arrives among those of each, and in which share of levels all do."""
    found = {(meeting.policy, meeting.partner): meeting for meeting in meetings}
    names = list(dict.fromkeys(meeting.policy for meeting in meetings))
    rows = []
    for policy in names:
        row = [found[policy, partner] for partner in names]
        cells = (f"{percent(each.individual_success)} (all {percent(each.cooperative_success)})" for each in row)
        rows.append((policy, *cells))
    heads = ["policy", *(f"among {name}\n[%]" for name in names)]
    return figure_table("who meets whom", heads, rows, **COMPACT)


def _meeting(policy: str, partner: str, rows: Mapping[str, Sequence[TeamRow]]) -> Meeting:
    pairs = dict.fromkeys([Arrangement(policy, partner), Arrangement(partner, policy)])
    solved, arrived, collided = [], [], []
    for levels in zip(*(rows[pair.name] for pair in pairs), strict=True):
        mine = [
            agent.episode.outcome
            for pair, level in zip(pairs, levels, strict=True)
            for agent, driver in zip(level.agents, pair.drivers(len(level.agents)), strict=True)
            if driver == policy
        ]
        arrived.append(mine.count("success"))
        collided.append(mine.count("collision"))
        solved.append(sum(level.is_success for level in levels))
    team = len(mine)
    shares = rate_of_agents(arrived, team), rate_of_agents(collided, team), rate_of_agents(solved, len(pairs))
    return Meeting(policy, partner, *shares)
