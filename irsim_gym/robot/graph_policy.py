"""An exported graph as a policy in the simulator, and beside the policy that it was made of."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Floats, Ints
from irsim_gym.base.families import DISTURBANCES
from irsim_gym.evaluation.policies.perception import Perception
from irsim_gym.evaluation.policies.policy import Policy, by_agent
from irsim_gym.robot.inputs import Measured, limits_of, measured
from irsim_gym.robot.parts.perceive import SeenMap
from irsim_gym.robot.policy_graph import PolicyGraph
from irsim_gym.scenario import Scenario
from irsim_gym.tasks import Episodes, Outcome


class GraphRunner:
    """Runs a graph for many robots at once, and keeps the states of each.

    Args:
        graph: The policy.
        n_robots: Number of robots.
    """

    def __init__(self, graph: PolicyGraph, n_robots: int) -> None:
        import onnxruntime

        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = 1
        self._session = onnxruntime.InferenceSession(graph.content, options, providers=["CPUExecutionProvider"])
        self.names = [tensor.name for tensor in self._session.get_inputs()]
        self._outputs = [tensor.name for tensor in self._session.get_outputs()]
        self._starts = graph.starts
        self.states = {name: np.stack([start] * n_robots) for name, start in graph.starts.items()}
        self._maps = [SeenMap(graph.perceives) for _ in range(n_robots)] if graph.perceives else []

    def begin(self, robots: Ints) -> None:
        """Forget everything of some robots."""
        for name, start in self._starts.items():
            self.states[name][robots] = start
        for robot in robots if self._maps else ():
            self._maps[robot].forget()

    def run(self, inputs: Measured, robots: Ints) -> NDArray[Any]:
        """Return the commands of some robots in SI units, ``(n, n_components)``, and keep their states.

        Args:
            inputs: All inputs, see ``inputs``.
            robots: The numbers of the robots, shape ``(n,)``.
        """
        outputs = dict(zip(self._outputs, self._session.run(None, inputs), strict=True))
        for name, state in self.states.items():
            state[robots] = outputs[f"{name}_next"]
        return np.asarray(outputs["command"])

    def inputs(self, values: Measured, robots: Ints) -> Measured:
        """Return all inputs of the graph, after adding scans to maps; once in a step.

        Args:
            values: What these robots measure, by the names of the inputs, ``(n, ...)``.
            robots: Their numbers, shape ``(n,)``.
        """
        every = {**values, **{name: state[robots] for name, state in self.states.items()}}
        if self._maps:
            seen = zip(robots, *(values[name] for name in ("ranges", "pose", "goal")), strict=True)
            every["way_on_seen_map"] = np.stack([self._maps[robot].way(*seen) for robot, *seen in seen])
        return {name: every[name] for name in self.names}


class GraphPolicy:
    """Drives all agents of an environment by a graph.

    Args:
        graph: The policy.
        perception: Its observations and its action.
        measure: Returns what an agent's robot measures, by the names of the graph's inputs.
        limits: Least and greatest command of the robots that it was made for, each ``(n_components,)``; None for those
            of the environment.
    """

    def __init__(
        self,
        graph: PolicyGraph,
        perception: Perception | None = None,
        *,
        measure: Callable[[Episodes, int], Measured] = measured,
        limits: tuple[Floats, Floats] | None = None,
    ) -> None:
        self.perception, self._measure, self._limits = perception, measure, limits
        self._graph = graph
        self._runner: GraphRunner | None = None

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Forget everything of the agents of these worlds."""
        n_robots = episodes.n_worlds * episodes.n_agents
        if self._runner is None or len(next(iter(self._runner.states.values()))) != n_robots:
            self._runner = GraphRunner(self._graph, n_robots)
        for agent in range(episodes.n_agents):
            self._runner.begin(worlds * episodes.n_agents + agent)

    def act(self, episodes: Episodes, worlds: Ints) -> NDArray[Any]:
        """Return the actions of the agents of worlds, ``(n, n_agents, ...)``."""
        assert self._runner is not None, "begin comes first"
        actions = []
        for agent in range(episodes.n_agents):
            robots, values = worlds * episodes.n_agents + agent, self._measure(episodes, agent)
            inputs = self._runner.inputs({name: rows[worlds] for name, rows in values.items()}, robots)
            self._runner.run(inputs, robots)
            actions.append(self._runner.states["action"][robots])
        commands = np.stack(actions, axis=1).astype(np.float64)
        if self._limits is not None:
            commands = rescaled(commands, self._limits, limits_of(episodes))
        if not episodes.n_discrete:
            return commands
        grid: Floats = episodes.terms["action"][0].arrays["grid"][0]
        return np.asarray(np.abs(commands[:, :, None] - grid).sum(axis=3).argmin(axis=2))


class DelayedPolicy:
    """A policy whose actions act some steps late; until the first one does, the robot stands.

    Args:
        policy: The policy.
        n_steps: Number of steps.
    """

    def __init__(self, policy: Policy, n_steps: int) -> None:
        self.policy, self.n_steps = policy, n_steps
        self._queue: dict[int, list[Any]] = {}

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Begin in these worlds, at rest."""
        self.policy.begin(episodes, worlds, levels)
        for w in worlds.tolist():
            self._queue[w] = [episodes.state.action[w].copy()] * self.n_steps

    def act(self, episodes: Episodes, worlds: Ints) -> NDArray[Any]:
        """Return the actions of some steps ago, ``(n, n_agents, n_components)``."""
        new = by_agent(np.asarray(self.policy.act(episodes, worlds)), episodes, worlds)
        for w, action in zip(worlds.tolist(), new, strict=True):
            self._queue[w].append(action)
        return np.array([self._queue[w].pop(0) for w in worlds.tolist()])


def without_latency(scenario: Scenario) -> Scenario:
    """Return a scenario whose commands act at once, to be played by a policy that is delayed itself."""
    kind = DISTURBANCES.entry("latency").kind
    lists = [scenario.disturbances, *(body.disturbances for body in scenario.bodies)]
    own, *rests = (tuple(one for one in some if not isinstance(one, kind)) for some in lists)
    bodies = (replace(body, disturbances=rest) for body, rest in zip(scenario.bodies, rests, strict=True))
    return replace(scenario, bodies=tuple(bodies), disturbances=own)


@dataclass
class ComparedPolicy:
    """A policy that drives, and a graph that sees the same: how far are the commands of the first agent apart?

    Attributes:
        policy: Drives.
        graph: Is compared.
        perception: The observations and the action of both.
        most: Greatest difference of a command so far [m/s, rad/s or rad].
        n_commands: Number of compared commands.
        samples: Inputs of the graph, its commands, and the level of each, at most ``n_samples``, by name.
        n_samples: Number of samples to keep.
    """

    policy: Policy
    graph: PolicyGraph
    perception: Perception | None = None
    most: float = 0.0
    n_commands: int = 0
    samples: dict[str, NDArray[Any]] = field(default_factory=dict)
    n_samples: int = 1000
    _runner: GraphRunner | None = None
    _levels: Ints = field(default_factory=lambda: np.zeros(0, np.int64))

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Begin in these worlds."""
        self.policy.begin(episodes, worlds, levels)
        if self._runner is None:
            self._runner, self._levels = GraphRunner(self.graph, episodes.n_worlds), np.zeros(episodes.n_worlds, int)
        self._runner.begin(worlds)
        self._levels[worlds] = levels

    def act(self, episodes: Episodes, worlds: Ints) -> NDArray[Any]:
        """Return the actions of the policy, and compare the commands that follow from them with the graph's."""
        assert self._runner is not None, "begin comes first"
        values = {name: rows[worlds] for name, rows in measured(episodes).items()}
        inputs = self._runner.inputs(values, worlds)
        commands, actions = self._runner.run(inputs, worlds), np.asarray(self.policy.act(episodes, worlds))
        if not episodes.n_discrete:
            # The graph remembers what was done: where the policy hunts, its last bit would grow from step to step.
            self._runner.states["action"][worlds] = first_actions(episodes, actions)
        # A robot whose episode has ended waits for its team: it is not driven any more.
        drives = episodes.view.infos["outcome"][worlds, 0] == Outcome.RUNNING
        apart = np.abs(commands - commands_of(episodes, actions, values))[drives]
        self.most = float(np.max(apart, initial=self.most))
        self.n_commands += len(apart)
        kept = {**inputs, "command": commands, "level": self._levels[worlds]}
        self._keep({name: rows[drives] for name, rows in kept.items()})
        return actions

    def _keep(self, rows: Mapping[str, NDArray[Any]]) -> None:
        for name, new in rows.items():
            earlier = self.samples.get(name, new[:0])
            self.samples[name] = np.concatenate([earlier, new])[: self.n_samples]


def commands_of(episodes: Episodes, actions: NDArray[Any], values: Measured) -> Floats:
    """Return the commands in the robot's frame that follow from the first agent's actions, ``(n, n_components)``."""
    low, high = limits_of(episodes)
    if episodes.n_discrete:
        commands = episodes.terms["action"][0].arrays["grid"][0][actions.reshape(len(actions), episodes.n_agents)[:, 0]]
    else:
        commands = first_actions(episodes, actions)
    return np.asarray(0.5 * (low + high) + commands.astype(np.float64) * (0.5 * (high - low)))


def first_actions(episodes: Episodes, actions: NDArray[Any]) -> NDArray[Any]:
    """Return the first agent's actions within [-1, 1], ``(n, n_components)``."""
    return np.asarray(np.clip(actions.reshape(len(actions), episodes.n_agents, -1)[:, 0], -1.0, 1.0))


def rescaled(actions: Floats, before: tuple[Floats, Floats], now: tuple[Floats, Floats]) -> Floats:
    """Return the actions in [-1, 1] of the same commands between other limits; commands beyond these are clipped."""
    (low, high), (least, most) = before, now
    commands = 0.5 * (low + high) + actions * (0.5 * (high - low))
    span = np.where(most > least, most - least, 1.0)
    return np.asarray(np.clip((2.0 * commands - least - most) / span, -1.0, 1.0))
