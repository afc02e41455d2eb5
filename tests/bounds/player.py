"""Plays a scenario in all the ways in which kernels are called: by itself, by hand, with learners and teams, drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from irsim_gym.base.families import OBSERVATIONS
from irsim_gym.envs.gymnasium.vector import WorldVectorEnv
from irsim_gym.envs.teams.batch import make_batch
from irsim_gym.errors import PlacementError, ScenarioError
from irsim_gym.evaluation.measures.optimum import Optima
from irsim_gym.live.world import load
from irsim_gym.rendering import Renderer
from irsim_gym.scenario import Scenario, load_scenario
from irsim_gym.simulator.engine import compile
from irsim_gym.simulator.running import shards
from irsim_gym.tasks.observations.goal import route
from irsim_gym.tasks.observations.seen_map import seen_grid

N_WORLDS = 2
PICTURE = (64, 48)
SMALL_WORLD = 12.0
"""Up to this size [m] shortest ways are sought too: plain Python takes long over a large grid."""

DISC = {"shape": {"name": "circle", "radius": 0.1}, "distribution": {"name": "random"}}
SMALL = {"pixels": 16, "metres": 6.0}
IMAGES = ("occupancy_image", "seen_map_image")
PICTURES = {"name": "blank", "observations": [{"name": name, **SMALL} for name in IMAGES]}
NUMBERS = {
    "name": "blank",
    "observations": [
        entry.name
        for entry in OBSERVATIONS
        if entry.name not in (*IMAGES, "neighbors") and not hasattr(entry.kind, "misfit")
    ],
    "rewards": [{"name": "progress", "potential": "geodesic", "cell": 0.5}, "clearance", "smoothness"],
    "endings": [{"name": "arrived", "wait": True}, "collided", "deadlocked", "left_world"],
    "audit": False,
}


def look_coarsely() -> None:
    """Let ways be sought over few cells: plain Python takes long over many."""
    route.CELL, route.FINEST, seen_grid.FINEST = 1.0, 12, 12


def share_among_threads() -> None:
    """Let worlds be shared among threads however little there is to do: each has scratch memory of its own."""
    shards.WORTH_S, shards.HEAD_START_S = 0.0, 1e-4


def alone(scenario: Scenario, steps: int) -> None:
    """Run by its own behaviours: several levels, one again, and what can be asked about bodies."""
    sim = compile(scenario, N_WORLDS, num_threads=2)
    everyone = np.arange(len(scenario.bodies))
    for seed in (0, 100):
        sim.reset(seed=seed)
        for _ in range(steps):
            sim.step()
    sim.run(lambda shard: sim.clearance(shard, everyone, np.zeros((N_WORLDS, len(everyone)))))
    for b, body in enumerate(scenario.bodies):
        if body.fov is not None and body.fov_radius is not None:
            sim.detected(b)
    sim.reset_to_start()
    sim.step()
    sim.refresh()


def by_hand(source: Any, steps: int) -> None:
    """Run with goals that are set and added, and with bodies that come and go."""
    with load(source) as world:
        world.resume()
        for robot in world.robots:
            robot.set_goal([[1, 1, 0], [2, 2], [3, 3]])
        for _ in range(steps):
            world.step()
        for robot in world.robots:
            robot.append_goal([2, 1])
        world.step()
        for robot in world.robots:
            robot.set_goal([2, 1])  # who loops comes back from it
        if world.scenario.occupied is None:
            world.remove(world.add(**DISC).name)
            world.add(**DISC)
        world.step()
        world.reset()
        world.step()
        world.reset(random=True)
        world.step()


def learner(scenario: Scenario, steps: int, task: Any = None) -> None:
    """Let one robot of each world learn: worlds end and begin anew, and one is reset by itself."""
    env = WorldVectorEnv(scenario, N_WORLDS, task=task, max_steps=max(steps - 1, 1), num_threads=2)
    env.action_space.seed(0)
    env.reset(seed=5)
    for _ in range(steps):
        env.step(env.action_space.sample())
    env.reset(seed=7, options={"reset_mask": np.arange(N_WORLDS) == 1})
    env.step(env.action_space.sample())


def with_ways(scenario: Scenario, steps: int) -> None:
    """Let a robot observe all that is numbers, and be paid by the way around what stands."""
    if max(scenario.world.width, scenario.world.height) <= SMALL_WORLD:
        learner(scenario, 1, NUMBERS)
        env = WorldVectorEnv(scenario)
        env.reset(seed=2)
        Optima("train").of(env.worlds.episodes, 0, 0)


def team(scenario: Scenario, steps: int, *, respawn: bool = False) -> None:
    """Let all robots learn, which begin anew alone or with their worlds."""
    batch = make_batch(scenario, N_WORLDS, num_threads=2, max_steps=2, respawn=respawn)
    batch.action_space.seed(0)
    batch.reset(seed=3)
    for _ in range(steps):
        batch.step(np.array([[batch.action_space.sample() for _ in range(batch.n_agents)] for _ in range(N_WORLDS)]))


def drawn(scenario: Scenario, steps: int) -> None:
    """Draw worlds by kernels, whole and in part."""
    sim = compile(scenario, N_WORLDS)
    sim.reset()
    parts = scenario, sim.model, sim.state, sim.sensors
    renderer = Renderer(*parts, size=PICTURE, explored=sim.explored, learners=scenario.robots)
    for _ in range(steps):
        sim.step()
    renderer.frames(range(N_WORLDS))
    renderer.look_at((1.0, 1.0, 3.0, 2.5))
    renderer.frame(1)


WAYS: dict[str, Callable[[Any, int], None]] = {
    "alone": alone,
    "by hand": by_hand,
    "learner": learner,
    "numbers": with_ways,
    "pictures": lambda scenario, steps: learner(scenario, 1, PICTURES),
    "team": team,
    "respawn": lambda scenario, steps: team(scenario, steps, respawn=True),
    "drawn": drawn,
}
IMPOSSIBLE = (PlacementError, ScenarioError)
"""A world that is too full, or in which nobody can learn: no fault of a kernel."""


def play(source: Any, steps: int) -> Iterator[str]:
    """Play a scenario in every way that it allows, and yield the names of these ways.

    Args:
        source: What ``load_scenario`` takes.
        steps: Steps in each way.
    """
    scenario = load_scenario(source, warn=False)
    for name, way in WAYS.items():
        try:
            way(source if name == "by hand" else scenario, steps)
        except IMPOSSIBLE:
            continue
        yield name
