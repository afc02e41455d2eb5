"""Whoever looks at a world gets the same world: state, model, groups, random streams, rewards, bit for bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym
from irsim_gym.rendering.windows.screen import Screen

SCENARIOS = (
    "car_dash",
    "cave",
    "cluttered_room",
    "field_of_view",
    "four_drives",
    "motion_noise",
    "multi_robot_rvo",
    "noisy_lidar",
    "random_outlines",
    "social_forces",
    "wandering_crowd",
    "drawing_options",
)
MODES = "rgb_array", "rgb_array_list", "human"
STEPS = 5


@pytest.fixture(autouse=True)
def shown(monkeypatch: pytest.MonkeyPatch) -> list[np.ndarray]:
    """Let windows be a list."""
    pictures: list[np.ndarray] = []
    monkeypatch.setattr(Screen, "show", lambda self, picture, seconds=0.0: pictures.append(picture))
    return pictures


def arrays_of(env: Any) -> dict[str, np.ndarray]:
    """Return copies of all arrays of a simulation: the moment, the constants, what sensors and behaviours keep."""
    simulation = env.unwrapped.worlds.simulation
    found = {f"state.{name}": value for name, value in vars(simulation.state).items()}
    found |= {f"model.{name}": value for name, value in vars(simulation.model).items()}
    parts = simulation.parts
    groups = (*parts.group_behaviors, *parts.behaviors, *parts.kinematics, *parts.sensors, *parts.placements)
    for k, group in enumerate(groups):
        found |= {f"groups[{k}].{name}": value for name, value in group.arrays.items()}
    if simulation.explored is not None:
        found["explored"] = simulation.explored
    return {name: value.copy() for name, value in found.items() if isinstance(value, np.ndarray)}


@pytest.mark.parametrize("number", range(len(SCENARIOS)), ids=SCENARIOS)
def test_rendering_changes_nothing(number: int, shown: list[np.ndarray]) -> None:
    for mode in (MODES[number % 3], MODES[(number + 1) % 3]):
        plain = irsim_gym.make(SCENARIOS[number])
        seen = irsim_gym.make(SCENARIOS[number], render_mode=mode)
        rng = np.random.default_rng(number)
        pictures = 0
        for seed in (7, None):
            assert_same(plain.reset(seed=seed), seen.reset(seed=seed))
            for _ in range(STEPS):
                pictures += count(seen.render())
                action = rng.uniform(-0.3, 0.3, plain.action_space.shape).astype(np.float32)
                answers = plain.step(action), seen.step(action)
                assert_same(*answers)
                if answers[0][2] or answers[0][3]:
                    break
            before, after = arrays_of(plain), arrays_of(seen)
            assert len(before) > 50
            assert [name for name in before if before[name].tobytes() != after[name].tobytes()] == []
        assert pictures + len(shown) > STEPS
        assert plain.unwrapped.np_random_seed == seen.unwrapped.np_random_seed
        assert plain.unwrapped.np_random.bit_generator.state == seen.unwrapped.np_random.bit_generator.state
        shown.clear()
        plain.close()
        seen.close()


def test_rendering_a_team_changes_nothing(shown: list[np.ndarray]) -> None:
    plain, seen = irsim_gym.parallel_env("circle_swap"), irsim_gym.parallel_env("circle_swap", render_mode="human")
    assert_same(plain.reset(seed=3), seen.reset(seed=3))
    for _ in range(STEPS):
        actions = {agent: np.full(plain.action_space(agent).shape, 0.4, np.float32) for agent in plain.agents}
        assert_same(plain.step(actions), seen.step(actions))
    assert arrays_of(plain).keys() == arrays_of(seen).keys()
    assert all(
        one.tobytes() == two.tobytes()
        for one, two in zip(arrays_of(plain).values(), arrays_of(seen).values(), strict=True)
    )
    assert len(shown) == STEPS + 1


def count(rendered: Any) -> int:
    if rendered is None:
        return 0
    return len(rendered) if isinstance(rendered, list) else 1


def assert_same(one: Any, two: Any) -> None:
    """Compare nested answers, arrays bit for bit."""
    assert type(one) is type(two)
    if isinstance(one, dict):
        assert one.keys() == two.keys()
        for key in one:
            assert_same(one[key], two[key])
    elif isinstance(one, tuple):
        for left, right in zip(one, two, strict=True):
            assert_same(left, right)
    elif isinstance(one, np.ndarray):
        assert (one.dtype, one.shape, one.tobytes()) == (two.dtype, two.shape, two.tobytes())
    else:
        assert one == two or (one != one and two != two)
