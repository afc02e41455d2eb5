"""What every trained policy is compared with: acting at random, and driving straight at the goal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import Floats, Ints
from irsim_gym.errors import UnknownNameError, suggestion
from irsim_gym.tasks import Episodes

DRAWS = 64
ANGLE_TOLERANCE = 0.1


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


class DashPolicy:
    """Drives straight at the goal, as the behaviour ``dash`` does: a baseline that sees no obstacle.

    A differential drive goes v_max cos(e) forward, where e is the goal's bearing, and turns at full rate, or at what
    its angular acceleration can still brake. The command is then put into the task's actions.
    """

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Do nothing: the policy has no memory."""

    def act(self, episodes: Episodes, worlds: Ints) -> NDArray[np.float64] | Ints:
        """Return the actions of worlds."""
        return to_actions(episodes, worlds, dash_command(episodes, worlds))


def dash_command(episodes: Episodes, worlds: Ints) -> Floats:
    """Return the velocities that ``dash`` asks for, ``(n, 2)`` [m/s, rad/s], within the robot's limits."""
    simulation = episodes.simulation
    model, state, body = simulation.model, simulation.state, int(simulation.agents[0])
    low, high = (_row(limit, worlds, body)[:, :2] for limit in (model.velocity_min, model.velocity_max))
    acceleration = _row(model.acceleration_limit, worlds, body)[:, 1]
    pose = state.pose[worlds, body]
    offset = state.goal[worlds, body, :2] - pose[:, :2]
    error = _wrap(np.arctan2(offset[:, 1], offset[:, 0]) - pose[:, 2])
    turn = _turn_rate(error, np.abs(high[:, 1]), acceleration, float(model.step_time[0]))
    command = np.stack([high[:, 0] * np.cos(error), turn], axis=1)
    arrived = np.hypot(offset[:, 0], offset[:, 1]) < _row(model.goal_threshold, worlds, body)
    command[arrived] = 0.0
    return np.asarray(np.clip(command, low, high))


def _turn_rate(error: Floats, fastest: Floats, acceleration: Floats, step_time: float) -> Floats:
    """Return the turn rates [rad/s] towards bearings ``error`` [rad]."""
    excess = np.maximum(np.abs(error) - ANGLE_TOLERANCE, 0.0)
    limited = np.isfinite(acceleration) & (acceleration > 0.0)
    braking = np.where(limited, acceleration, 0.0)
    reach = np.sqrt((braking * step_time) ** 2 + 2.0 * braking * excess) - braking * step_time
    rate = np.where(limited, np.minimum(fastest, reach), fastest)
    return np.where(np.abs(error) < ANGLE_TOLERANCE, 0.0, np.where(error > 0.0, rate, -rate))


def _wrap(angle: Floats) -> Floats:
    """Return angles in [-pi, pi]; those that lie there already are returned unchanged."""
    return np.where(np.abs(angle) <= np.pi, angle, np.pi - np.mod(np.pi - angle, 2.0 * np.pi))


def _row(field: Floats, worlds: Ints, body: int) -> Floats:
    """Return a body's rows of a field that worlds may share."""
    return np.asarray(field[worlds % field.shape[0], body])


REFERENCES: dict[str, type[RandomPolicy] | type[DashPolicy]] = {"random": RandomPolicy, "dash": DashPolicy}


def reference_policy(name: str) -> RandomPolicy | DashPolicy:
    """Make a reference policy.

    Raises:
        UnknownNameError: There is none of that name.
    """
    if name not in REFERENCES:
        raise UnknownNameError(f"no reference policy named '{name}'{suggestion(name, REFERENCES)}")
    return REFERENCES[name]()


def to_actions(episodes: Episodes, worlds: Ints, command: Floats) -> NDArray[np.float64] | Ints:
    """Return the actions that ask for commands ``(n, 2)``: exact in [-1, 1], or the nearest of a task's choices."""
    model, body = episodes.simulation.model, int(episodes.simulation.agents[0])
    low, high = (_row(limit, worlds, body)[:, :2] for limit in (model.velocity_min, model.velocity_max))
    half = np.maximum(0.5 * (high - low), 1e-12)
    action: Floats = np.clip((command - 0.5 * (low + high)) / half, -1.0, 1.0)
    if episodes.action_kind == "continuous":
        return action
    options = episodes.task.action
    forward = np.rint(0.5 * (action[:, 0] + 1.0) * (options.linear - 1)).astype(np.int64)
    turn = np.rint(0.5 * (action[:, 1] + 1.0) * (options.angular - 1)).astype(np.int64)
    return np.asarray(forward * options.angular + turn)
