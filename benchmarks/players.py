"""Worlds that are ready to be stepped: each player knows its next step, and how many agents that moves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from standard_worlds import PUSH_STEPS, RUN_STEPS, TEAM_STEPS

import irsim_gym as ig
from irsim_gym import WorldEnv, WorldVectorEnv
from irsim_gym.envs import Worlds

N_ACTIONS = 64
"""Steps after which the random actions repeat."""


@dataclass(frozen=True)
class Player:
    """A world or a batch that was reset.

    Attributes:
        step: Plays one step; worlds that end begin anew within it.
        n_agents: Agent-steps of one call.
        rewind: Goes back to the start, where a run must not go on for ever.
        n_steps: Steps of such a run; 0 where it may go on for ever.
        worlds: The worlds themselves, where there is no more than them.
        places: Returns x, y of each agent of the first world [m], where all decide for themselves.
    """

    step: Callable[[], Any]
    n_agents: int
    rewind: Callable[[], Any] | None = None
    n_steps: int = 0
    worlds: Worlds | None = None
    places: Callable[[], Any] | None = None


def actions(*shape: int) -> NDArray[np.float32]:
    """Return random actions in [-1, 1] for some steps, shape ``(N_ACTIONS, *shape, 2)``."""
    return np.random.default_rng(0).uniform(-1.0, 1.0, (N_ACTIONS, *shape, 2)).astype(np.float32)


def single(scenario: Mapping[str, Any]) -> Player:
    """Return one world as a ``gymnasium.Env``."""
    env = WorldEnv(scenario)
    env.reset(seed=0)
    given = _forever(actions())

    def step() -> None:
        _, _, terminated, truncated, _ = env.step(next(given))
        if terminated or truncated:
            env.reset()

    return Player(step, 1)


def core(scenario: Mapping[str, Any], n_worlds: int, n_threads: int = 1, team: bool = False) -> Player:
    """Return a batch below all interfaces: observations lie in its arrays, ended worlds begin anew."""
    worlds = Worlds(scenario, n_worlds, num_threads=n_threads, team=team)
    worlds.begin(range(n_worlds), range(n_worlds), [{}] * n_worlds, lambda w: w)
    view, n_agents = worlds.episodes.view, worlds.episodes.n_agents
    given = _forever(actions(n_worlds, n_agents))

    def step() -> None:
        worlds.step(next(given))
        ended = np.flatnonzero(~view.live.any(axis=1))
        if len(ended):
            worlds.begin_next(ended)

    return Player(step, n_worlds * n_agents, worlds=worlds)


def vector(scenario: Mapping[str, Any], n_worlds: int) -> Player:
    """Return a batch as a ``gymnasium.vector.VectorEnv``."""
    env = WorldVectorEnv(scenario, n_worlds, autoreset_mode="SameStep")
    env.reset(seed=0)
    given = _forever(actions(n_worlds))
    return Player(lambda: env.step(next(given)), n_worlds)


def vec_env(scenario: Mapping[str, Any], n_worlds: int) -> Player:
    """Return a batch as a ``VecEnv`` of Stable-Baselines3."""
    env = ig.sb3.make_vec_env(scenario, n_worlds, seed=0, render_mode=None)
    env.reset()
    given = _forever(actions(n_worlds))
    return Player(lambda: env.step(next(given)), n_worlds)


def team(scenario: Mapping[str, Any], n_worlds: int) -> Player:
    """Return a batch whose robots all learn, each with an observation of its own; from the start in each run."""
    return _from_start(core(scenario, n_worlds, team=True), n_worlds, TEAM_STEPS)


def pushing(scenario: Mapping[str, Any], n_worlds: int) -> Player:
    """Return a batch whose robots push bodies; from the start in each run."""
    return _from_start(core(scenario, n_worlds), n_worlds, PUSH_STEPS)


def crowd(scenario: Mapping[str, Any], n_worlds: int = 1) -> Player:
    """Return worlds whose bodies all decide for themselves."""
    simulation = ig.compile(ig.load_scenario(scenario), n_worlds)
    simulation.reset(0)
    pose = simulation.state.pose
    return Player(
        simulation.step,
        n_worlds * len(simulation.parts.names),
        lambda: simulation.reset(0),
        RUN_STEPS,
        places=lambda: pose[0, :, :2].tolist(),
    )


def twin(n_worlds: int) -> Player:
    """Return a batch of S1 in C; RuntimeError without a compiler."""
    from c_twin import Twin

    batch, given = Twin(n_worlds), _forever(actions(n_worlds))
    return Player(lambda: batch.step(next(given)), n_worlds)


def _from_start(player: Player, n_worlds: int, n_steps: int) -> Player:
    """Return a batch that goes back to its first levels after some steps."""

    def rewind() -> None:
        assert player.worlds is not None
        player.worlds.begin(range(n_worlds), range(n_worlds), [{}] * n_worlds, lambda w: w)

    return replace(player, rewind=rewind, n_steps=n_steps)


def _forever(rows: NDArray[np.float32]) -> Any:
    while True:
        yield from rows
