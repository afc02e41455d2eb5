"""Plays a scenario with random actions: values stay in their spaces, a batch equals single worlds, levels are data."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from irsim_gym.envs.teams.batch import Batch, make_batch
from irsim_gym.evaluation.levels.draw import draw_levels
from irsim_gym.scenario import Scenario, load_scenario
from irsim_gym.scenario.reading.level_checks import with_levels
from irsim_gym.simulator.engine import compile

N_WORLDS = 3
SEEDS = (5, 90, 5)
"""Each seed begins other levels in the same worlds; the last are those of the first again."""


class OutOfSpaceError(AssertionError):
    """A value is not in its space."""


def check(source: Any, steps: int) -> Iterator[str]:
    """Play a scenario in several ways, and yield what was checked.

    Args:
        source: What ``load_scenario`` takes.
        steps: Steps after each reset.
    """
    scenario = load_scenario(source, warn=False)
    agents = {} if scenario.task.get("agents") == "all" else {"agents": scenario.bodies[0].name}
    task = {**scenario.task, **agents}
    batch = play_together(scenario, task, steps)
    yield "spaces"
    yield f"{batch.n_agents} agents"
    if not batch.worlds.episodes.waits:
        respawning = make_batch(scenario, 2, task=task, respawn=True, world_steps=9)
        played = respawning.reset(seed=3).observation
        look(respawning, played)
        for action in random_actions(respawning, steps):
            look(respawning, respawning.step(action).observation)
        yield "respawn"
    if scenario.levels is None:
        play_file(scenario, task, batch, steps)
        yield "levels"


def play_together(scenario: Scenario, task: Any, steps: int) -> Batch:
    """Compare a batch with a single world, which plays the same levels in another order."""
    batch, single = (make_batch(scenario, n, task=task, num_threads=min(n, 2)) for n in (N_WORLDS, 1))
    for seed in SEEDS:
        together = [batch.reset(seed=seed), *(batch.step(action) for action in random_actions(batch, steps))]
        for moment in together:
            look(batch, moment.observation)
        for w in reversed(range(N_WORLDS)):
            alone = [single.reset(seed=seed + w)]
            alone += [single.step(action[w : w + 1]) for action in random_actions(batch, steps)]
            for step, (one, other) in enumerate(zip(alone, together, strict=True)):
                where = f"world {w} of seed {seed}, step {step}"
                same(one.observation, other.observation, w, f"{where}: observation")
                same(one.reward, other.reward, w, f"{where}: reward")
                same(one.terminated, other.terminated, w, f"{where}: terminated")
    return batch


def play_file(scenario: Scenario, task: Any, batch: Batch, steps: int) -> None:
    """Compare levels from a file with those that are drawn."""
    simulation = compile(scenario, 2, agents=batch.worlds.episodes.task.agents)
    levels = with_levels(scenario, draw_levels(simulation, ["train"], N_WORLDS))
    filed = make_batch(levels, N_WORLDS, task=task)
    for order in ((2, 0, 1), (0, 1, 2)):
        options = [{"split": "train", "level": level} for level in order]
        drawn, given = batch.begin([None] * N_WORLDS, options), filed.begin([None] * N_WORLDS, options)
        follows = np.ones(N_WORLDS, np.bool_)  # after an end, another level begins
        for action in [None, *random_actions(batch, steps)]:
            if action is not None:
                drawn, given = batch.step(action), filed.step(action)
                follows &= ~drawn.began.any(axis=1)
            for w in np.flatnonzero(follows):
                same(given.observation, drawn.observation, w, f"level {order[w]} of a file", whole=w)


def random_actions(batch: Batch, steps: int) -> Iterator[Any]:
    """Yield actions of all worlds, always the same ones; half of them are at the ends."""
    rng = np.random.default_rng(0)
    shape = (N_WORLDS if batch.n_worlds == 1 else batch.n_worlds, batch.n_agents)
    for _ in range(steps):
        if not batch.action_space.shape:
            yield rng.integers(0, batch.action_space.n, shape)
        else:
            action = rng.uniform(-1.0, 1.0, (*shape, *batch.action_space.shape)).astype(np.float32)
            yield np.where(rng.random(action.shape) < 0.5, np.sign(action), action)


def look(batch: Batch, observation: Any) -> None:
    """Refuse observations that are not in the space of an agent, and states that are not in [-1, 1]."""
    for w in range(batch.n_worlds):
        for a in range(batch.n_agents):
            own = {key: part[w, a] for key, part in observation.items()} if isinstance(observation, dict) else None
            own = observation[w, a] if own is None else own
            if not batch.observation_space.contains(own):
                told = strays(batch.observation_space, own)
                raise OutOfSpaceError(f"world {w}, agent {a}: {told}; {batch.worlds.episodes.observation_terms}")
    state = batch.state()
    if not ((state >= -1.0) & (state <= 1.0)).all():
        raise OutOfSpaceError(f"the state of the team: {state}")


def strays(space: Any, own: Any) -> list[str]:
    """Return which numbers of an observation are outside of its space, with their bounds."""
    parts = {"": (space, own)} if not isinstance(own, dict) else {key: (space[key], own[key]) for key in own}
    told = []
    for name, (box, values) in parts.items():
        wrong = np.flatnonzero(~((values >= box.low) & (values <= box.high)))
        told += [f"{name}[{k}] is {values[k]!r}, not from {box.low[k]!r} to {box.high[k]!r}" for k in wrong[:3]]
    return told


def same(one: Any, other: Any, world: Any, where: str, whole: int | None = None) -> None:
    """Refuse what differs between the single world and world ``world`` of the batch."""
    pairs = [(one, other)] if not isinstance(one, dict) else [(one[key], other[key]) for key in one]
    for a, b in pairs:
        first = a[0] if whole is None else a[whole]
        second = b[world] if whole is None else b[whole]
        if not np.array_equal(first, second, equal_nan=True):
            raise AssertionError(f"{where} differs: {first} and {second}")
