"""Scaling of numbers for networks."""

import numpy as np

from irsim_gym.simulator.world.names import Floats, kernel


@kernel
def unit(value: float) -> np.float32:
    """Return a number clipped to [-1, 1] as float32; 0 for NaN."""
    return np.float32(0.0) if np.isnan(value) else np.float32(min(max(value, -1.0), 1.0))


@kernel
def diagonal(bounds: Floats) -> float:
    """Return the length of the world's diagonal [m], from ``Model.bounds``, shape ``(4,)``."""
    width, height = bounds[2] - bounds[0], bounds[3] - bounds[1]
    return float(np.sqrt(width * width + height * height))
