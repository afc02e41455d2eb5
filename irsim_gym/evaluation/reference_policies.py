"""What every trained policy is compared with: acting at random, and the behaviours of the language."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from irsim_gym import families
from irsim_gym.arraytypes import Floats, Ints
from irsim_gym.engine import Shard
from irsim_gym.engine.measures import measure
from irsim_gym.errors import UnknownNameError, suggestion
from irsim_gym.families import BEHAVIORS, KINEMATICS
from irsim_gym.tasks import Episodes
from irsim_gym.world.group import Group
from irsim_gym.world.model import OMNI_WORLD

DRAWS = 64


class RandomPolicy:
    """Draws every action uniformly; a level's actions follow from its number alone.

    Args:
        seed: Another seed gives other actions on the same levels.
    """

    def __init__(self, seed: int = 0) -> None:
        self.seed = seed
        self._generators: dict[int, np.random.Generator] = {}
        self._drawn: dict[int, Floats] = {}
        self._used: dict[int, int] = {}

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Start the levels' own random generators."""
        for world, level in zip(worlds.tolist(), levels.tolist(), strict=True):
            self._generators[world] = np.random.default_rng((self.seed, level))
            self._used[world] = DRAWS

    def act(self, episodes: Episodes, worlds: Ints) -> NDArray[np.float64] | Ints:
        """Return the actions of worlds."""
        size = 1 if episodes.action_kind == "discrete" else len(episodes.action_low)
        drawn = np.stack([self._next(world, size) for world in worlds.tolist()])
        if episodes.action_kind == "discrete":
            return (drawn[:, 0] * episodes.n_discrete).astype(np.int64)
        return np.asarray(episodes.action_low + drawn * (episodes.action_high - episodes.action_low), np.float64)

    def _next(self, world: int, size: int) -> Floats:
        """Return the world's next ``size`` numbers from [0, 1); they are drawn in blocks."""
        if self._used[world] >= DRAWS:
            self._drawn[world] = self._generators[world].random((DRAWS, size))
            self._used[world] = 0
        row: Floats = self._drawn[world][self._used[world]]
        self._used[world] += 1
        return row


class BehaviorPolicy:
    """Commands the learner as a registered behaviour does: a baseline that has nothing to learn.

    A learner whose scenario gives it that behaviour already has it with the options that stand there.

    Args:
        name: The behaviour's name in YAML.
    """

    def __init__(self, name: str) -> None:
        families.load()
        self.kind = BEHAVIORS.entry(name).kind
        self.name = name
        self._episodes: Episodes | None = None
        self._group: Group | None = None

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Look at the drive, and at the sizes of the bodies.

        Raises:
            ValueError: The behaviour cannot command the learner's drive.
        """
        simulation = episodes.simulation
        if self._episodes is not episodes:
            self._group = self._bind(episodes)
            self._episodes = episodes
        if self.kind.reads_neighbors:
            measure(worlds, simulation.parts.everyone, simulation.model)

    def _bind(self, episodes: Episodes) -> Group:
        simulation = episodes.simulation
        body = simulation.scenario.bodies[int(simulation.agents[0])]
        drive = KINEMATICS.name_of(type(body.kinematics))
        if drive not in self.kind.kinematics:
            raise ValueError(f"'{self.name}' cannot drive kinematics '{drive}' of '{body.name}'")
        options = body.behavior if isinstance(body.behavior, self.kind) else self.kind()
        group = Group(self.kind, [options], simulation.agents[:1])
        self.kind.prepare(group, simulation.model, simulation.shards.n_slots)
        return group

    def act(self, episodes: Episodes, worlds: Ints) -> NDArray[np.float64] | Ints:
        """Return the actions of worlds."""
        return to_actions(episodes, worlds, self.command(episodes, worlds))

    def command(self, episodes: Episodes, worlds: Ints) -> Floats:
        """Return the velocities that the behaviour asks for, ``(n, n_components)`` [m/s, rad/s], within the limits."""
        assert self._group is not None
        model, state = episodes.simulation.model, episodes.simulation.state
        size, body = len(episodes.action_low), int(episodes.simulation.agents[0])
        self.kind.decide(self._group, model, state, Shard(np.ascontiguousarray(worlds)))
        low, high = (_row(limit, worlds, body)[:, :size] for limit in (model.velocity_min, model.velocity_max))
        return np.asarray(np.clip(state.command[worlds, body, :size], low, high))


def _row(field: Floats, worlds: Ints, body: int) -> Floats:
    """Return a body's rows of a field that worlds may share."""
    return np.asarray(field[worlds % field.shape[0], body])


REFERENCES = ("random", "dash", "rvo")
ALWAYS_SHOWN = ("random", "dash")
"""Those that stand beside every evaluated policy; the others see more of the world than a learner does."""


def reference_policy(name: str) -> RandomPolicy | BehaviorPolicy:
    """Make a reference policy.

    Raises:
        UnknownNameError: There is none of that name.
    """
    if name not in REFERENCES:
        raise UnknownNameError(f"no reference policy named '{name}'{suggestion(name, REFERENCES)}")
    return RandomPolicy() if name == "random" else BehaviorPolicy(name)


def to_actions(episodes: Episodes, worlds: Ints, command: Floats) -> NDArray[np.float64] | Ints:
    """Return the actions that ask for commands ``(n, n_components)``: exact in [-1, 1], or the nearest choices."""
    model, body = episodes.simulation.model, int(episodes.simulation.agents[0])
    size = len(episodes.action_low)
    if model.drive[body] == OMNI_WORLD and episodes.task.action.frame == "body":
        command = _into_body_frame(command, episodes.simulation.state.pose[worlds, body, 2])
    low, high = (_row(limit, worlds, body)[:, :size] for limit in (model.velocity_min, model.velocity_max))
    half = np.maximum(0.5 * (high - low), 1e-12)
    action: Floats = np.clip((command - 0.5 * (low + high)) / half, -1.0, 1.0)
    if episodes.action_kind == "continuous":
        return action
    options = episodes.task.action
    counts = (options.linear, options.angular) if size == 2 else (options.linear, options.lateral, options.angular)
    steps = [np.rint(0.5 * (action[:, c] + 1.0) * (count - 1)).astype(np.int64) for c, count in enumerate(counts)]
    return np.asarray(np.ravel_multi_index(steps, counts), np.int64)


def _into_body_frame(velocity: Floats, heading: Floats) -> Floats:
    """Return velocities ``(n, 2)`` [m/s] of the world frame in that of bodies with these headings [rad]."""
    cosine, sine = np.cos(heading), np.sin(heading)
    ahead = cosine * velocity[:, 0] + sine * velocity[:, 1]
    return np.stack([ahead, cosine * velocity[:, 1] - sine * velocity[:, 0]], axis=1)
