"""In every adapter a level from a file equals the drawn one, bit for bit."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contract_tools import assert_same

import irsim_gym as ig
from irsim_gym.evaluation.levels.draw import draw_levels
from irsim_gym.evaluation.requests.episode_setup import make_episodes

SEED, STEPS, COUNT = 5, 12, 8
Played = Iterator[Any]


def single(data: dict[str, Any], steps: int = STEPS) -> Played:
    env = ig.make(data)
    yield env.reset(seed=SEED, options={"split": "test"})
    env.action_space.seed(0)
    for _ in range(steps):
        yield env.step(env.action_space.sample())


def vector(data: dict[str, Any]) -> Played:
    envs = ig.make_vec(data, num_envs=3)
    yield envs.reset(seed=SEED, options={"split": "test"})
    envs.action_space.seed(0)
    for _ in range(STEPS):
        yield envs.step(envs.action_space.sample())


def parallel(data: dict[str, Any]) -> Played:
    env = ig.parallel_env(data)
    yield env.reset(seed=SEED, options={"split": "test"})
    for agent in env.possible_agents:
        env.action_space(agent).seed(0)
    for _ in range(STEPS):
        yield env.step({agent: env.action_space(agent).sample() for agent in env.agents})


def sb3(data: dict[str, Any]) -> Played:
    envs = ig.sb3.make_vec_env(data, 3)
    envs.seed(SEED)
    envs.set_options({"split": "test"})
    yield envs.reset()
    for _ in range(STEPS):
        yield envs.step(np.full((3, *envs.action_space.shape), 0.5, np.float32))


def live(data: dict[str, Any]) -> Played:
    with ig.load(data, seed=SEED) as world:
        for _ in range(STEPS):
            world.step()
            yield [body.state.copy() for body in world.objects]


def evaluated(data: dict[str, Any]) -> Played:
    rows = ig.evaluate(data, "dash", levels=COUNT, n_worlds=3, references=False).rows
    yield [tuple(vars(row).values()) for row in rows["dash"]]


FACES = [
    ("cluttered_room", "test", single), ("cluttered_room", "test", vector), ("cluttered_room", "test", sb3),
    ("cluttered_room", "test", evaluated), ("cluttered_room", "train", live),
    ("circle_swap", "test", parallel), ("push_box", "test", single),
]  # fmt: skip


def plain(name: str) -> dict[str, Any]:
    """Return a shipped scenario as a mapping, with the values of its parameters."""
    return {key: value for key, value in ig.load_scenario(name).source.data.items() if key != "parameters"}


@pytest.mark.parametrize(("name", "split", "face"), FACES, ids=[f"{face.__name__} {name}" for name, _, face in FACES])
def test_levels_from_a_file_are_the_drawn_ones(
    tmp_path: Path, name: str, split: str, face: Callable[[dict[str, Any]], Played]
) -> None:
    data = plain(name)
    episodes = make_episodes(data, n_worlds=COUNT, team=face is parallel)
    (tmp_path / "levels.npz").write_bytes(draw_levels(episodes.simulation, [split], COUNT).content())
    given = {**data, "levels": str(tmp_path / "levels.npz")}
    for moment, (one, other) in enumerate(zip(face(given), face(data), strict=True)):
        assert_same(one, other, f"{moment}")


def test_a_chain_of_levels_stays_in_the_file_and_knows_its_numbers(tmp_path: Path) -> None:
    data = plain("cluttered_room")
    episodes = make_episodes(data, n_worlds=2)
    (tmp_path / "levels.npz").write_bytes(draw_levels(episodes.simulation, ["train"], 2).content())
    env = ig.make({**data, "levels": str(tmp_path / "levels.npz")})
    first = {level: env.reset(options={"level": level})[0] for level in (0, 1)}
    assert not np.array_equal(first[0], first[1])
    seen = set()
    for _ in range(20):
        observation, info = env.reset()
        assert_same(observation, first[info["level"]])
        seen.add(info["level"])
    assert seen == {0, 1}


def test_more_levels_than_the_file_has_are_not_evaluated(tmp_path: Path) -> None:
    data = plain("cluttered_room")
    (tmp_path / "levels.npz").write_bytes(draw_levels(make_episodes(data).simulation, ["test"], 2).content())
    with pytest.raises(ig.errors.IrsimGymError, match=r"levels.npz has 2 test levels, but 3 are asked for"):
        ig.evaluate({**data, "levels": str(tmp_path / "levels.npz")}, "dash", levels=3)
