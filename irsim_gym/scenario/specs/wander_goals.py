"""The mapping ``wander_goals`` of a behaviour."""

from irsim_gym.base.options import kind, option


@kind
class WanderGoals:
    """The positions of a wandering body's goals, and when they change other than on arrival."""

    radius: float | None = option(
        None,
        gt=0.0,
        unit="m",
        meaning="Goals lie on a circle of this radius around the middle of range_low and range_high; default: "
        "anywhere between them.",
    )
    jitter: float = option(
        0.0, ge=0.0, unit="m", meaning="Each goal on the circle is shifted: drawn evenly from a disc of this radius."
    )
    keep_first: bool = option(
        False, meaning="The first goal is that of the entry or its distribution; by default it is drawn like the rest."
    )
    interval: float | None = option(
        None,
        gt=0.0,
        unit="s",
        meaning="At multiples of this time a body gives up its goal for a new one, with the probability chance; in "
        "whole steps. It has no effect on learners.",
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
