"""Neural networks in NumPy: they run the shipped policies without PyTorch.

A network is plain data: a list of steps, each with its kind, options and arrays.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.errors import IrsimGymError, suggestion

Options = Mapping[str, Any]
"""Options of a step: its ``kind``, and the parameters of this kind."""
Arrays = Mapping[str, NDArray[Any]]
MAX_TERMS = 200_000
"""Largest number of multiplications in one matrix product. OpenBLAS uses several threads above 262,144."""


def apply_steps(steps: Sequence[Options], arrays: Sequence[Arrays], rows: NDArray[Any]) -> Floats:
    """Apply steps to rows, one after the other, in double precision.

    Args:
        steps: Options of each step.
        rows: Inputs, ``(n, ...)``.
    """
    values: Floats = rows.astype(np.float64)
    for step, step_arrays in zip(steps, arrays, strict=True):
        values = STEPS[step["kind"]](values, step_arrays, step)
    return values


def check_steps(steps: Sequence[Options]) -> None:
    """Check that all steps are of a known kind.

    Raises:
        IrsimGymError: If a kind is unknown. The message suggests a similar one.
    """
    for step in steps:
        if step.get("kind") not in STEPS:
            near = suggestion(str(step.get("kind")), STEPS)
            raise IrsimGymError(f"no step of a network is named '{step.get('kind')}'{near}")


def linear(rows: Floats, arrays: Arrays, step: Options) -> Floats:
    """Return ``rows @ weight.T + bias``: ``(n, n_in)`` to ``(n, n_out)``."""
    return product(rows, arrays["weight"]) + arrays["bias"]


def convolution(rows: Floats, arrays: Arrays, step: Options) -> Floats:
    """Return the cross-correlation with each filter, unpadded: ``(n, n_in, height, width)`` to ``(n, n_out, ...)``."""
    weight = arrays["weight"]
    windows = sliding_window_view(rows, weight.shape[2:], axis=(2, 3))
    down, right = step["stride"]
    seen = windows[:, :, ::down, ::right].transpose(0, 2, 3, 1, 4, 5)
    products = product(seen.reshape(-1, weight[0].size), weight.reshape(len(weight), -1)) + arrays["bias"]
    return products.reshape(*seen.shape[:3], -1).transpose(0, 3, 1, 2)


def product(rows: Floats, weight: Floats) -> Floats:
    """Return ``rows @ weight.T``, computed a few rows at a time.

    OpenBLAS distributes larger products over threads, which slow each other down on a busy machine. All parts have
    the same size, so the result of a row does not depend on the other rows.
    """
    size = max(2, MAX_TERMS // weight.size)
    parts = -(-len(rows) // size)
    padded = np.zeros((parts * size, rows.shape[1]))
    padded[: len(rows)] = rows
    products: Floats = padded.reshape(parts, size, -1) @ weight.T
    return products.reshape(-1, len(weight))[: len(rows)]


def gru_cell(rows: Floats, memory: Floats, arrays: Arrays) -> Floats:
    """Return the next memory of a GRU: ``(n, n_in)`` and ``(n, size)`` to ``(n, size)``.

    The weights of the reset gate, the update gate and the candidate are stacked in this order, as in PyTorch.
    """
    inputs = product(rows, arrays["weight_ih"]) + arrays["bias_ih"]
    recurrent = product(memory, arrays["weight_hh"]) + arrays["bias_hh"]
    size = memory.shape[1]
    reset = _sigmoid(inputs[:, :size] + recurrent[:, :size])
    update = _sigmoid(inputs[:, size : 2 * size] + recurrent[:, size : 2 * size])
    new = np.tanh(inputs[:, 2 * size :] + reset * recurrent[:, 2 * size :])
    return np.asarray((1.0 - update) * new + update * memory)


def standardize(rows: Floats, arrays: Arrays, step: Options) -> Floats:
    """Normalise rows as ``VecNormalize`` does: subtract the mean, divide by the standard deviation, and clip."""
    scaled = (rows - arrays["mean"]) / np.sqrt(arrays["var"] + step["epsilon"])
    return np.asarray(np.clip(scaled, -step["clip"], step["clip"]).astype(np.float32), np.float64)


def gelu(rows: Floats) -> Floats:
    """Return ``x`` times the cumulative distribution function of the standard normal distribution at ``x``."""
    from scipy.special import ndtr

    return np.asarray(rows * ndtr(rows))


def _sigmoid(rows: Floats) -> Floats:
    return 0.5 * (1.0 + np.tanh(0.5 * rows))


def _elementwise(function: Callable[[Floats], Floats]) -> Callable[[Floats, Arrays, Options], Floats]:
    return lambda rows, arrays, step: function(rows)


STEPS: dict[str, Callable[[Floats, Arrays, Options], Floats]] = {
    "linear": linear,
    "convolution": convolution,
    "standardize": standardize,
    "flatten": _elementwise(lambda rows: rows.reshape(len(rows), -1)),
    "pixels": _elementwise(lambda rows: rows / 255.0),
    "relu": _elementwise(lambda rows: np.maximum(rows, 0.0)),
    "tanh": _elementwise(np.tanh),
    "sigmoid": _elementwise(_sigmoid),
    "silu": _elementwise(lambda rows: rows * _sigmoid(rows)),
    "gelu": _elementwise(gelu),
    "elu": lambda rows, arrays, step: np.where(rows > 0.0, rows, step["alpha"] * np.expm1(np.minimum(rows, 0.0))),
    "leaky_relu": lambda rows, arrays, step: np.where(rows > 0.0, rows, step["slope"] * rows),
}
"""Function of each kind of step. It takes the rows, and the step's arrays and options."""
