"""Options of all behaviours for what bodies do at their goals; a member's own precede those of its group."""

import math
from collections.abc import Iterator
from typing import Any

from irsim_gym.base.options import crossed_bounds, defaults, kind, option
from irsim_gym.scenario.specs.wander_goals import WanderGoals

_LOW, _HIGH = (0.0, 0.0, -math.pi), (10.0, 10.0, math.pi)
"""IR-SIM's default bounds of goals: its default world of 10 m by 10 m, any heading [m, m, rad]."""


@kind
class RenewsGoals:
    """Options of behaviours; those of a group are for its members without a behavior of their own."""

    wander: bool = option(
        False,
        meaning="Draw a new random goal after each arrival; in a group, of members without a behavior of their own.",
    )
    loop: bool = option(False, meaning="Begin again with the first goal after the last, likewise.")
    range_low: tuple[float, float, float] = option(
        _LOW, unit="m, m, rad", meaning="Lower bounds of a wandering body's goals."
    )
    range_high: tuple[float, float, float] = option(
        _HIGH, unit="m, m, rad", meaning="Upper bounds of a wandering body's goals."
    )
    wander_goals: WanderGoals = option(
        defaults(WanderGoals), meaning="With wander: goals on a circle, a first goal that is kept, changes on the way."
    )


def renewal_problems(options: Any) -> Iterator[tuple[str, str]]:
    """Yield key and message of invalid or conflicting options."""
    yield from crossed_bounds(options.range_low, options.range_high)
    goals = options.wander_goals
    if goals != defaults(WanderGoals) and not options.wander:
        yield "wander_goals", "needs wander: true beside it"
    if goals.jitter > 0.0 and goals.radius is None:
        yield "wander_goals", f"jitter: {goals.jitter:g} needs a radius: only goals on a circle are shifted"
    if goals.chance < 1.0 and goals.interval is None:
        yield "wander_goals", f"chance: {goals.chance:g} needs an interval [s]; a new goal on arrival is certain"
