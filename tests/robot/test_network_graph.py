"""Networks as graphs: equal to ``ShelfPolicy`` for each step, each way to make an action, and a memory."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from irsim_gym.evaluation.saved_policies import array_network
from irsim_gym.evaluation.saved_policies.shelf import ShelfPolicy
from irsim_gym.robot.network_graph import STEPS, network_graph
from irsim_gym.tasks.terms.graph import Graph

onnxruntime = pytest.importorskip("onnxruntime")

N, WIDTH, SIZE = 16, 5, 6
RNG = np.random.default_rng(3)


def numbers(*shape: int) -> Any:
    return RNG.normal(0.0, 0.7, shape).astype(np.float32)


def policy(activation: dict[str, Any], output: str, *, remembers: bool = False) -> ShelfPolicy:
    """Return a network with random weights: normalisation, a layer, perhaps a GRU, an activation and a layer."""
    n_outputs = 4 if output == "argmax" else 2
    width = SIZE * (2 if remembers else 1)
    arrays = {
        "observation//low": np.full(WIDTH, -9.0, np.float32),
        "observation//high": np.full(WIDTH, 9.0, np.float32),
        "part//0/mean": RNG.normal(size=WIDTH),
        "part//0/var": RNG.uniform(0.5, 2.0, WIDTH),
        "part//2/weight": numbers(SIZE, WIDTH),
        "part//2/bias": numbers(SIZE),
        "trunk/1/weight": numbers(n_outputs, width),
        "trunk/1/bias": numbers(n_outputs),
    }
    standardize = {"kind": "standardize", "epsilon": 1e-8, "clip": 2.0}
    form: dict[str, Any] = {
        "observation": {"": "float32"},
        "parts": {"": [standardize, {"kind": "flatten"}, {"kind": "linear"}]},
        "trunk": [activation, {"kind": "linear"}],
        "output": output,
        "action": {"n": n_outputs},
    }
    if output != "argmax":
        form["action"] = {"dtype": "float32"}
        arrays |= {"action/low": np.array([-1.0, -0.5], np.float32), "action/high": np.array([1.0, 0.8], np.float32)}
    if remembers:
        form["memory"] = {"kind": "gru", "size": SIZE}
        arrays |= {f"memory/0/weight_{part}": numbers(3 * SIZE, SIZE) for part in ("ih", "hh")}
        arrays |= {f"memory/0/bias_{part}": numbers(3 * SIZE) for part in ("ih", "hh")}
    return ShelfPolicy(form, arrays)


class Twin:
    """A network as a graph, with its state."""

    def __init__(self, made: ShelfPolicy) -> None:
        graph = Graph()
        found = network_graph(made, graph, {"": graph.input("seen", np.float32, WIDTH)})
        graph.output("action", found, *(() if made.output == "argmax" else made.action_space.shape))
        self.session = onnxruntime.InferenceSession(graph.model("network").SerializeToString())
        self.states = {name: np.stack([start] * N) for name, start in graph.starts.items()}

    def act(self, seen: Any) -> Any:
        action, *states = self.session.run(None, {"seen": seen, **self.states})[::-1]
        self.states = dict(zip(self.states, states, strict=True))
        return action


ACTIVATIONS = [{"kind": kind} for kind in ("relu", "tanh", "sigmoid", "silu", "gelu")]
ACTIVATIONS += [{"kind": "elu", "alpha": 0.7}, {"kind": "leaky_relu", "slope": 0.02}]


def test_each_step_for_rows_has_a_twin() -> None:
    assert set(array_network.STEPS) - set(STEPS) == {"convolution", "pixels"}
    assert {step["kind"] for step in ACTIVATIONS} | {"standardize", "flatten", "linear"} == set(STEPS)


@pytest.mark.parametrize("activation", ACTIVATIONS, ids=lambda step: step["kind"])
def test_activations_equal_those_of_the_package(activation: dict[str, Any]) -> None:
    made, seen = policy(activation, "clip"), numbers(N, WIDTH) * 3.0
    np.testing.assert_allclose(Twin(made).act(seen), made.predict(seen)[0], rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("output", ["clip", "squash", "argmax"])
def test_actions_are_made_alike(output: str) -> None:
    made, seen = policy({"kind": "tanh"}, output), numbers(N, WIDTH)
    np.testing.assert_allclose(Twin(made).act(seen), made.predict(seen)[0], rtol=0.0, atol=1e-6)


def test_a_memory_goes_on_alike() -> None:
    made, state = policy({"kind": "relu"}, "clip", remembers=True), None
    twin = Twin(made)
    for _ in range(5):
        seen = numbers(N, WIDTH)
        expected, state = made.predict(seen, state)
        np.testing.assert_allclose(twin.act(seen), expected, rtol=0.0, atol=1e-6)
