"""Options of all behaviours for what bodies do at their goals; a member's own precede those of its group."""

import math
from collections.abc import Callable, Iterator
from typing import Any, ClassVar

from irsim_gym.base.arraytypes import Pose
from irsim_gym.base.options import crossed_bounds, defaults, kind, option


@kind
class WanderGoals:
    """The positions of a wandering body's goals, and when they change other than on arrival."""

    radius: float | None = option(
        None, gt=0.0, unit="m", meaning="Goals lie on a circle of this radius amid the range; default: anywhere in it."
    )
    jitter: float = option(0.0, ge=0.0, unit="m", meaning="Goals on the circle are drawn from a disc of this radius.")
    keep_first: bool = option(False, meaning="The first goal is that of the entry; by default it is drawn as the rest.")
    interval: float | None = option(
        None, gt=0.0, unit="s", meaning="At its multiples a body, no learner, takes a new goal with probability chance."
    )
    patience: float | None = option(
        None,
        gt=0.0,
        unit="s",
        meaning="A body that a collision with one that can move has held so long gets a new goal, and drives on "
        "through such bodies until it touches nothing. Default: it stands for as long as they touch. No effect on "
        "learners.",
    )
    chance: float = option(1.0, ge=0.0, le=1.0, meaning="Probability of a new goal at each interval.")


_LOW, _HIGH = (0.0, 0.0, -math.pi), (10.0, 10.0, math.pi)
"""IR-SIM's default bounds of goals: its default world of 10 m by 10 m, any heading [m, m, rad]."""


@kind
class RenewsGoals:
    """Options of behaviours; those of a group are for its members without a behavior of their own."""

    further_problems: ClassVar[Callable[[Any], Iterator[tuple[str, str]]] | None] = None
    """Yields key and message of what else is wrong with the options of a behaviour."""

    wander: bool = option(False, meaning="Draw a new goal after each arrival; in groups, of members without behavior.")
    loop: bool = option(False, meaning="Begin again with the first goal after the last, likewise.")
    range_low: Pose = option(_LOW, unit="m, m, rad", meaning="Lower bounds of a wandering body's goals.")
    range_high: Pose = option(_HIGH, unit="m, m, rad", meaning="Upper bounds of a wandering body's goals.")
    wander_goals: WanderGoals = option(defaults(WanderGoals), meaning="With wander: goals on circles, their changes.")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from crossed_bounds(self.range_low, self.range_high)
        goals = self.wander_goals
        if goals != defaults(WanderGoals) and not self.wander:
            yield "wander_goals", "needs wander: true beside it"
        if goals.jitter > 0.0 and goals.radius is None:
            yield "wander_goals", f"jitter: {goals.jitter:g} needs a radius: only goals on a circle are shifted"
        if goals.chance < 1.0 and goals.interval is None:
            yield "wander_goals", f"chance: {goals.chance:g} needs an interval [s]; a new goal on arrival is certain"
        if self.further_problems is not None:
            yield from self.further_problems()
