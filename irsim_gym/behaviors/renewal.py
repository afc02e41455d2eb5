"""Options of group behaviours for what members do at their goals; a member's own behaviour comes before them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from irsim_gym.scenario.options import crossed_bounds, option

_MEMBERS = "a member without a behavior of its own"

WANDER = option(False, meaning=f"Draw a new random goal after each arrival of {_MEMBERS}.")
LOOP = option(False, meaning=f"Let {_MEMBERS} begin again with its first goal after the last.")
LOW = option((0.0, 0.0, -math.pi), unit="m, m, rad", meaning="Lower bounds of a wandering member's goals.")
HIGH = option((10.0, 10.0, math.pi), unit="m, m, rad", meaning="Upper bounds of a wandering member's goals.")


def renewal_problems(options: Any) -> Iterator[tuple[str, str]]:
    """Yield key and message of what cannot be."""
    yield from crossed_bounds(options.range_low, options.range_high)
