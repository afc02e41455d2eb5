"""Infos are the same by world, by rows and as a batch, and in copies of the worlds."""

from __future__ import annotations

import pickle
from copy import deepcopy

import numpy as np
import pytest

from irsim_gym.envs.gymnasium.worlds import Worlds

COPIES = {"itself": lambda worlds: worlds, "deepcopy": deepcopy, "pickle": lambda w: pickle.loads(pickle.dumps(w))}


@pytest.fixture(scope="module")
def played():
    """Three worlds with two robots after some steps."""
    worlds = Worlds("circle_swap", 3, team=True, parameters={"n_robots": 2})
    worlds.begin(range(3), [4, 5, 6], [{}] * 3, int)
    for _ in range(5):
        worlds.step(np.ones((3, 2, 2), np.float32))
    return worlds


@pytest.mark.parametrize("copied", COPIES)
def test_every_form_tells_what_the_arrays_hold(played, copied):
    worlds = COPIES[copied](played)
    view, names = worlds.episodes.view, worlds.episodes.reward_names
    places = np.array([2, 0]), np.array([1, 0])
    rows = [worlds.infos.of_row(row) for row in worlds.infos.rows(2 * places[0] + places[1])]
    for w, a, row in zip(*places, rows, strict=True):
        info = worlds.infos.of(w, a)
        assert info == row
        assert info == {
            **{key: values[w, a] for key, values in view.infos.items()},
            **{f"reward/{name}": paid for name, paid in zip(names, view.reward_terms[w, a], strict=True)},
        }
        assert {type(value) for value in info.values()} <= {int, float, bool}
    assert info["steps"] == 5


@pytest.mark.parametrize("copied", COPIES)
def test_a_batch_holds_the_first_agents_of_the_chosen_worlds(played, copied):
    worlds = COPIES[copied](played)
    view = worlds.episodes.view
    chosen = np.array([True, False, True])
    for mask in (None, chosen):
        infos = worlds.infos.batched(mask)
        terms = {f"reward/{name}": view.reward_terms[..., i] for i, name in enumerate(worlds.episodes.reward_names)}
        for key, values in {**view.infos, **terms}.items():
            wanted = values[:, 0] if mask is None else np.where(mask, values[:, 0], 0)
            np.testing.assert_array_equal(infos[key], wanted)
            assert infos[key].dtype == values.dtype
            assert infos[f"_{key}"].tolist() == (mask.tolist() if mask is not None else [True] * 3)
        assert len(infos) == 2 * (len(view.infos) + len(terms))


def test_copies_are_told_their_own_episodes(played):
    worlds = deepcopy(played)
    worlds.step(np.ones((3, 2, 2), np.float32))
    assert (worlds.infos.of(0)["steps"], played.infos.of(0)["steps"]) == (6, 5)
    assert worlds.infos.rows(np.array([1]))[0] != played.infos.rows(np.array([1]))[0]
    assert worlds.infos.batched()["steps"].tolist() == [6, 6, 6]


def test_one_world_is_told_anew_each_time():
    worlds = Worlds("sparse_circles")
    worlds.begin([0], [3], [{}], int)
    seen = []
    for _ in range(3):
        worlds.step(np.ones((1, 1, 2), np.float32))
        seen.append(worlds.infos.of(0))
    assert [info["steps"] for info in seen] == [1, 2, 3]
    assert len({id(info) for info in seen}) == 3
