"""The network of a policy as a graph: the twins of the steps of ``array_network``, in double precision."""

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from gymnasium.spaces import Box

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.saved_policies.array_network import Arrays, Options
from irsim_gym.evaluation.saved_policies.shelf import ShelfPolicy
from irsim_gym.tasks.terms.graph import Graph, Value


def network_graph(policy: ShelfPolicy, graph: Graph, seen: Mapping[str, Value]) -> Value:
    """Return what a network makes of observations: the numbers of an action, float64, or the number of a choice.

    Args:
        seen: The parts of the observation by name, ``(batch, width)``, float32.

    Raises:
        IrsimGymError: The network has a step that is not among ``STEPS``.
    """
    parts = [_applied(steps, policy.part_arrays[name], seen[name]) for name, steps in policy.parts.items()]
    features = graph.join(parts)
    if policy.memory is not None:
        before = graph.state("memory", np.zeros(policy.memory["weight_hh"].shape[1], np.float32))
        after = _gru(features, before.cast(np.float64), policy.memory)
        graph.keep("memory", after.cast(np.float32))
        features = graph.join([features, after])
    found = _applied(policy.trunk, policy.trunk_arrays, features)
    if policy.output == "argmax":
        return found.op("ArgMax", np.int64, axis=1, keepdims=0)
    assert isinstance(policy.action_space, Box)
    low, high = policy.action_space.low.astype(np.float64), policy.action_space.high.astype(np.float64)
    if policy.output == "squash":
        found = (found.op("Tanh") + 1.0) * (0.5 * (high - low)) + low
    return found.between(low, high)


def _applied(steps: Sequence[Options], arrays: Sequence[Arrays], seen: Value) -> Value:
    found = seen.cast(np.float64)
    for step, own in zip(steps, arrays, strict=True):
        if step["kind"] not in STEPS:
            raise IrsimGymError(f"a network with the step '{step['kind']}' cannot leave: it takes no pictures")
        found = STEPS[step["kind"]](found, own, step)
    return found


def _stored(value: Value, array: Floats) -> Value:
    """Return weights as a constant: in single precision where they were trained in it, which halves the file."""
    small = array.astype(np.float32)
    return value.graph.constant(small if np.array_equal(small, array) else array).cast(np.float64)


def _dense(rows: Value, weight: Floats, bias: Floats) -> Value:
    # As Gemm before an activation, onnxruntime 1.17 fuses it to an operator that it lacks for float64.
    return rows.times(_stored(rows, weight.T.copy())) + _stored(rows, bias)


def _gru(rows: Value, memory: Value, arrays: Arrays) -> Value:
    """Return the next memory; see ``array_network.gru_cell``."""
    given = _dense(rows, arrays["weight_ih"], arrays["bias_ih"])
    known = _dense(memory, arrays["weight_hh"], arrays["bias_hh"])
    size = arrays["weight_hh"].shape[1]
    both = (given + known).columns(0, 2 * size).op("Sigmoid")
    reset, update = both.columns(0, size), both.columns(size, 2 * size)
    new = (given.columns(2 * size, 3 * size) + reset * known.columns(2 * size, 3 * size)).op("Tanh")
    return (1.0 - update) * new + update * memory


def _standardized(rows: Value, arrays: Arrays, step: Options) -> Value:
    scaled: Value = (rows - arrays["mean"]) / np.sqrt(arrays["var"] + step["epsilon"])
    return scaled.between(-step["clip"], step["clip"]).cast(np.float32).cast(np.float64)


def _gelu(rows: Value, arrays: Arrays, step: Options) -> Value:
    # ONNX Runtime has Erf in single precision only.
    return rows * ((rows * math.sqrt(0.5)).cast(np.float32).op("Erf").cast(np.float64) + 1.0) * 0.5


def _negative(slope: Callable[[Value, Options], Value]) -> Callable[[Value, Arrays, Options], Value]:
    """Return an activation that keeps positive numbers, and changes the others."""
    return lambda rows, arrays, step: (rows > 0.0).where(rows, slope(rows.least(0.0), step))


def _named(kind: str) -> Callable[[Value, Arrays, Options], Value]:
    return lambda rows, arrays, step: rows.op(kind)


STEPS: dict[str, Callable[[Value, Arrays, Options], Value]] = {
    "linear": lambda rows, arrays, step: _dense(rows, arrays["weight"], arrays["bias"]),
    "standardize": _standardized,
    "flatten": lambda rows, arrays, step: rows,
    "relu": _named("Relu"),
    "tanh": _named("Tanh"),
    "sigmoid": _named("Sigmoid"),
    # As a product with a sigmoid, onnxruntime 1.20 fuses it to an operator that it lacks on a CPU.
    "silu": lambda rows, arrays, step: rows / ((-rows).op("Exp") + 1.0),
    "gelu": _gelu,
    "elu": _negative(lambda rows, step: (rows.op("Exp") - 1.0) * step["alpha"]),
    "leaky_relu": _negative(lambda rows, step: rows * step["slope"]),
}
"""Twins of ``array_network.STEPS``, for rows of numbers."""
