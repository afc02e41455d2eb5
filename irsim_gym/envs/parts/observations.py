"""What observations of all forms have in common: an array, or a dict of arrays."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from irsim_gym.envs.parts.spaces import Observation


def on_each(observation: Any, change: Callable[[Any], Any]) -> Any:
    """Return what a function makes of an observation's array (or tensor), or of each of them."""
    if isinstance(observation, dict):
        return {name: change(array) for name, array in observation.items()}
    return change(observation)


def concatenated(parts: Sequence[Observation], join: Callable[[Sequence[Any]], Any] = np.concatenate) -> Any:
    """Return several observations of one form as one, their arrays one after the other.

    Args:
        parts: The observations, one at least.
        join: What puts arrays together: ``np.stack`` for observations of single robots.
    """
    if isinstance(parts[0], dict):
        return {name: join([part[name] for part in parts]) for name in parts[0]}
    return join(parts)
