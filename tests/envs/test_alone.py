"""One world by itself: the short way in does what the long one does."""

from __future__ import annotations

import pickle
from copy import deepcopy

import numpy as np
import pytest

from irsim_gym.base.kernels.replay import is_possible
from irsim_gym.envs.gymnasium.single import WorldEnv
from irsim_gym.envs.gymnasium.worlds import Worlds

SCENARIO = "sparse_circles"
needs_recording = pytest.mark.skipif(not is_possible(), reason="nothing is recorded without compiling")


def begun() -> WorldEnv:
    env = WorldEnv(SCENARIO)
    env.reset(seed=5)
    return env


def the_same(one, other) -> None:
    np.testing.assert_array_equal(one[0], other[0])
    assert one[1:] == other[1:]


@needs_recording
def test_the_short_way_is_taken_and_gives_the_same_as_a_batch_of_one(monkeypatch):
    env, worlds = begun(), Worlds(SCENARIO)
    worlds.begin([0], [5], [{}], int)
    for k, action in enumerate(np.random.default_rng(0).uniform(-1.2, 1.2, (40, 2)).astype(np.float32)):
        observation, reward, terminated, truncated, info = env.step(action)
        worlds.step(action.reshape(1, 1, 2))
        view = worlds.episodes.view
        np.testing.assert_array_equal(observation, view.observation[0, 0])
        assert (reward, terminated, truncated) == (view.reward[0, 0], view.terminated[0, 0], view.truncated[0, 0])
        assert info == worlds.infos.of(0)
        if terminated or truncated:
            break
        if k == 0:  # recorded by now
            monkeypatch.setattr(env.worlds.episodes, "step", lambda *_: pytest.fail("the long way was taken"))
    assert info["steps"] > 10


@pytest.mark.parametrize(
    "form",
    [
        np.float64,
        np.int64,
        lambda action: np.repeat(action, 2)[::2],
        lambda action: np.broadcast_to(action[:1], (2,)),
        list,
        lambda action: action.astype(">f8"),
    ],
    ids=["float64", "integer", "strided", "read-only", "list", "other bytes"],
)
def test_actions_in_any_form(form):
    action = np.ones(2, np.float32)
    the_same(begun().step(form(action)), begun().step(action))


@pytest.mark.parametrize("bad", [[np.nan, 0.0], [0.0, -np.inf]])
def test_an_action_that_is_not_finite_moves_nothing(bad):
    env, untouched = begun(), begun()
    env.step(np.ones(2)), untouched.step(np.ones(2))
    with pytest.raises(ValueError, match="not finite"):
        env.step(np.array(bad))
    the_same(env.step(np.zeros(2)), untouched.step(np.zeros(2)))


@pytest.mark.parametrize("copied", [deepcopy, lambda env: pickle.loads(pickle.dumps(env))], ids=["deepcopy", "pickle"])
def test_copies_go_their_own_way(copied):
    env = begun()
    env.step(np.ones(2))
    copy = copied(env)
    kept = env.step(np.array([1.0, -1.0]))
    for action in ([1.0, 1.0], [1.0, 1.0]):
        other = copy.step(np.array(action))
    assert (kept[4]["steps"], other[4]["steps"]) == (2, 3)
    assert not np.array_equal(kept[0], other[0])
    again = begun()
    for action in ([1.0, 1.0], [1.0, 1.0], [1.0, 1.0]):
        wanted = again.step(np.array(action))
    the_same(other, wanted)


def test_what_is_returned_stays_what_it_was():
    env = begun()
    first = env.step(np.ones(2))
    kept = first[0].copy(), dict(first[4])
    env.step(np.ones(2))
    np.testing.assert_array_equal(first[0], kept[0])
    assert first[4] == kept[1]
    assert [type(value) for value in first[1:4]] == [float, bool, bool]


def test_a_new_time_limit_counts():
    env = begun()
    env.step(np.zeros(2))
    env.worlds.limit(3)
    assert [env.step(np.zeros(2))[3] for _ in range(2)] == [False, True]
