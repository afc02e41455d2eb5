"""What the conformance tests share."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np

import irsim_gym  # noqa: F401
from irsim_gym.envs.gymnasium.registration import ANY

SHIPPED = sorted(one for one in gymnasium.registry if one.startswith("irsim_gym/") and one != ANY)
FEATURES = {
    "corridor", "empty_goal", "crossing", "dense_room", "cluttered_room", "sparse_circles",
    "car_dash", "noisy_lidar", "wandering_crowd", "mixed_obstacles",
}  # fmt: skip
# Costly checks run on these, which hold every feature that an environment could trip over.
CHOSEN = [one for one in SHIPPED if one.removeprefix("irsim_gym/").removesuffix("-v0") in FEATURES]
STILL = "irsim_gym/sparse_circles-v0"
MOVING = "irsim_gym/crossing-v0"


def assert_same(one: Any, other: Any, path: str = "") -> None:
    """Two results are equal bit for bit: types, dtypes, shapes, keys and values."""
    assert type(one) is type(other), (path, type(one), type(other))
    if isinstance(one, dict):
        assert one.keys() == other.keys(), (path, one.keys() ^ other.keys())
        for key in one:
            assert_same(one[key], other[key], f"{path}.{key}")
    elif isinstance(one, tuple | list):
        assert len(one) == len(other), path
        for k, (a, b) in enumerate(zip(one, other, strict=True)):
            assert_same(a, b, f"{path}[{k}]")
    elif isinstance(one, np.ndarray):
        assert (one.dtype, one.shape) == (other.dtype, other.shape), (path, one.dtype, other.dtype)
        if one.dtype == object:
            assert_same(one.tolist(), other.tolist(), path)
        else:
            np.testing.assert_array_equal(one, other, err_msg=path)
    else:
        both_are_nan = one != one and other != other
        assert one == other or both_are_nan, (path, one, other)


def arrays_in(data: Any) -> Iterator[np.ndarray]:
    """All arrays of a nested result."""
    if isinstance(data, np.ndarray):
        if data.dtype == object:
            yield from arrays_in(data.tolist())
        else:
            yield data
    elif isinstance(data, dict):
        for value in data.values():
            yield from arrays_in(value)
    elif isinstance(data, tuple | list):
        for value in data:
            yield from arrays_in(value)


def forward_actions(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Random actions of robots that mostly drive ahead, so that they arrive, collide and leave."""
    actions = rng.uniform(-1.0, 1.0, shape).astype(np.float32)
    actions[..., 0] = np.abs(actions[..., 0])
    actions[..., 1] *= 0.4
    return actions
