"""What the members of a disturbance have in each level: its numbers, a random stream, and a count of its calls."""

from dataclasses import dataclass

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints, Words
from irsim_gym.base.kernels import kernel
from irsim_gym.base.kernels.structs import Struct
from irsim_gym.base.rng import mix, uniform
from irsim_gym.simulator.world.model import Model

ROUNDING = 1e-9
"""A time that exceeds a whole number of steps by this share of one counts as that number."""


@dataclass(repr=False)
class Disturbed(Struct):
    """The members of a disturbance, and what a level has drawn for them.

    Attributes:
        members: Body of each member, shape ``(n_members,)``.
        low: Lower ends of the options of type ``Drawn``, in their order and units, shape ``(n_members, n_options)``.
        high: Their upper ends, likewise.
        keys: Numbers that tell the members' random streams apart, shape ``(n_members,)``.
        values: What the level has drawn, shape ``(n_worlds, n_members, n_options)``.
        random: States of the members' random streams, shape ``(n_worlds, n_members)``.
        count: Number of calls since the member has begun its episode, likewise.
    """

    members: Ints
    low: Floats
    high: Floats
    keys: Words
    values: Floats
    random: Words
    count: Ints


@kernel
def begin_disturbed(worlds: Ints, disturbed: Disturbed, model: Model) -> None:
    """Draw the numbers of a level. They depend on its seed, the member and the kind, and on nothing else.

    Reads: disturbed (high, keys, low, random), model (level_random).
    Writes: disturbed (count, random, values).
    """
    for w in worlds:
        for k in range(disturbed.members.shape[0]):
            disturbed.random[w, k] = mix(model.level_random[w] ^ disturbed.keys[k])
            disturbed.count[w, k] = 0
            for i in range(disturbed.low.shape[1]):
                low, high = disturbed.low[k, i], disturbed.high[k, i]
                disturbed.values[w, k, i] = uniform(disturbed.random[w], k, low, high)


@kernel(inlined=True)
def whole_steps(time: float, step_time: float) -> int:
    """Return a time in steps, rounded up.

    Args:
        time: The time [s].
        step_time: Duration of a step [s].
    """
    return int(np.ceil(time / step_time - ROUNDING))
