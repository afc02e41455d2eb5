"""The audit of rewards: compares the cost of an early end with the possible cost of continuing."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from irsim_gym.base.errors import UnknownNameError
from irsim_gym.base.families import ENDINGS, REWARDS
from irsim_gym.scenario.text.source import Place
from irsim_gym.tasks.definition.layers import Merged
from irsim_gym.tasks.terms.outcome import Outcome

ROUNDING = 1e-9
"""Largest difference of sums of weights that counts as none."""
Terms = Mapping[str, list[tuple[Place, Any]]]


@dataclass(frozen=True)
class Sharing:
    """How a team shares rewards.

    Attributes:
        team_reward: Share of each term that is the mean over the team.
        n_agents: Number of learners.
    """

    team_reward: float
    n_agents: int

    @property
    def own(self) -> float:
        """Share of its own rewards and penalties that an agent gets itself; 1 without sharing."""
        return 1.0 - self.team_reward * (1.0 - 1.0 / max(self.n_agents, 1))


def check_audit(terms: Terms, sharing: Sharing, merged: Merged) -> None:
    """Report rewards that a learner would exploit.

    The roles of kinds and weights >= 0 ensure that a reward is positive only as a difference of potentials or as the
    bonus for success. In addition, the running cost of a whole episode must not exceed the penalty for each failure
    that ends it. Otherwise an early crash or escape would be the best policy for a learner that finds no way to the
    goal. With equal costs it is not, because a crash is paid beside what the steps before it cost.

    Args:
        terms: The terms by family, with their places.
        sharing: How rewards are shared.
        merged: Collects the problems.
    """
    rewards = [reward for _, reward in terms["rewards"]]
    running = [reward for reward in rewards if reward.role == "running" and reward.weight > 0.0]
    cost = sum(reward.weight for reward in running)
    for place, ending in terms["endings"]:
        if ending.outcome == Outcome.SUCCESS or not running:
            continue
        amounts = [(reward, _least(reward, ending)) for reward in rewards if _pays_for(reward, ending.outcome)]
        penalty = sum(amount for _, amount in amounts)
        if sharing.own * penalty >= cost - ROUNDING:
            continue
        culprit: Place = ("team_reward",) if penalty >= cost - ROUNDING else place
        parts = _penalty_parts(amounts, sharing)
        message = (
            f"an episode that ends as '{ending_for(ending.outcome)}' costs {sharing.own * penalty:g}{parts}, "
            f"one that continues can cost {cost:g} ({_sum((reward, reward.weight) for reward in running)}): "
            f"{_advice(ending.outcome, bool(amounts), cost, sharing)}"
        )
        merged.report.add(merged.own_place(("rewards",), culprit), message)


def ending_for(outcome: object) -> str:
    """Return the name of the ending that leads to an outcome."""
    names = [entry.name for entry in ENDINGS if entry.kind.outcome == outcome]
    return names[0] if names else str(outcome)


def _pays_for(reward: Any, outcome: Any) -> bool:
    return bool(reward.role == "penalty" and reward.outcome == outcome)


def _least(reward: Any, ending: Any) -> float:
    """Return the least penalty if an episode ends in this way."""
    return float(reward.least(getattr(ending, "bodies", None)) if hasattr(reward, "least") else reward.weight)


def _penalty_parts(amounts: list[tuple[Any, float]], sharing: Sharing) -> str:
    """Return the parts of a penalty as text; empty without a penalty."""
    if not amounts:
        return ""
    if sharing.own == 1.0:
        return f" ({_sum(amounts)})"
    why = f"team_reward {sharing.team_reward:g}, {sharing.n_agents} learners"
    return f" ({_sum(amounts)}, of which a share of {sharing.own:.3g} is the robot's own: {why})"


def _advice(outcome: object, is_paid: bool, cost: float, sharing: Sharing) -> str:
    """Return advice about an end that costs too little."""
    weight = f"{cost / sharing.own:.4g}"
    if is_paid:
        shared = "" if sharing.own == 1.0 else " or team_reward"
        return f"raise the former above {weight}, lower the latter{shared}, or say 'audit: false'"
    names = [entry.name for entry in REWARDS if _pays_for(entry.kind, outcome)]
    if not names:
        return "there is no penalty for such an end; lower the latter, or say 'audit: false'"
    return f"add {{name: {names[0]}, weight: ...}} above {weight} to rewards, lower the latter, or say 'audit: false'"


def _sum(amounts: Iterable[tuple[Any, float]]) -> str:
    """Return terms with their amounts as text: ``time 4 + clearance 12``."""
    return " + ".join(f"{_name(reward)} {amount:g}" for reward, amount in amounts)


def _name(reward: object) -> str:
    try:
        return REWARDS.name_of(type(reward))
    except UnknownNameError:
        return type(reward).__name__
