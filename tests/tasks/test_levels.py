"""Training never meets a level of another split."""

from __future__ import annotations

import numpy as np
import pytest
from task_tools import play

from irsim_gym.base.rng import later_level, level_stream, stream_base
from irsim_gym.errors import UnknownNameError
from irsim_gym.tasks.episodes.levels import CHAIN, SPLITS, check_split, take_levels
from irsim_gym.tasks.terms.episode_state import EpisodeState

RANDOM = {"distribution": {"name": "random"}}


def streams(split: str, levels: range) -> set[int]:
    base = stream_base("cluttered_room", split)
    return {int(level_stream(base, level)) for level in levels}


def test_splits_share_no_stream() -> None:
    found = [streams(split, range(20_000)) for split in SPLITS]
    assert sum(map(len, found)) == len(set().union(*found)) == 60_000


def test_a_chain_stays_in_its_split() -> None:
    kept = streams("dev", range(10_000)) | streams("test", range(10_000))
    n_worlds = 64
    base = stream_base("cluttered_room", "train")
    sizes = dict.fromkeys(("agent", "action", "ending", "reward", "feature", "extra"), 1)
    state = EpisodeState.allocate({"world": n_worlds, **sizes})
    state.base[:], state.first_level[:], state.chosen[:] = base, np.arange(n_worlds), CHAIN
    met: set[int] = set()
    for number in range(200):
        state.episode[:] = number
        take_levels(np.arange(n_worlds), state)
        assert (state.stream == [level_stream(base, here) for here in state.level[:, 0].tolist()]).all()
        met |= set(state.stream.tolist())
    assert len(met) == 200 * n_worlds
    assert not met & kept


def test_the_first_level_is_the_given_one_and_later_ones_lie_beyond_ordinary_seeds() -> None:
    assert later_level(17, 0) == 17
    later = [int(later_level(17, k)) for k in range(1, 1000)]
    assert min(later) >= 2**52
    assert len(set(later)) == len(later)


def test_unknown_split() -> None:
    with pytest.raises(UnknownNameError, match=r"no split named 'tset' \(did you mean 'test'\?\)"):
        check_split("tset")


def test_levels_are_the_same_in_any_batch_and_differ_between_splits() -> None:
    batch, single = play(RANDOM, n_worlds=4), play(RANDOM)
    poses = batch.simulation.state.pose
    for split in SPLITS:
        batch.begin(np.arange(4), np.array([7, 8, 9, 10]), split)
        single.begin(np.array([0]), np.array([9]), split)
        assert (single.view.observation[0] == batch.view.observation[2]).all()
        assert (single.simulation.state.pose[0] == poses[2]).all()
    starts = []
    for split in SPLITS:
        single.begin(np.array([0]), np.array([9]), split)
        starts.append(single.simulation.state.pose[0, 0].tolist())
    assert len(set(map(tuple, starts))) == 3


def test_begin_next_follows_from_the_first_level_alone() -> None:
    one, other = play(RANDOM, n_worlds=2), play(RANDOM, n_worlds=2)
    one.begin_next(np.array([1]))
    one.begin_next(np.array([0, 1]))
    other.begin_next(np.array([0, 1]))
    other.begin_next(np.array([1]))
    assert one.view.infos["level"].tolist() == other.view.infos["level"].tolist()
    assert (one.simulation.state.pose == other.simulation.state.pose).all()


def test_begin_refuses_what_is_no_level() -> None:
    episodes = play()
    with pytest.raises(ValueError, match="levels must be >= 0, got -1"):
        episodes.begin(np.array([0]), np.array([-1]))
    with pytest.raises(ValueError, match="same length"):
        episodes.begin(np.array([0]), np.array([1, 2]))


def test_a_chosen_level_is_begun_once_within_the_split() -> None:
    one, other = play(RANDOM, n_worlds=2), play(RANDOM, n_worlds=2)
    for episodes in (one, other):
        episodes.begin(np.arange(2), np.array([3, 4]), "dev")
    one.choose(np.array([1]), np.array([77]))
    both = np.arange(2)
    one.begin_next(both)
    other.begin(np.array([1]), np.array([77]), "dev")
    assert one.state.level[:, 0].tolist() == [later_level(3, 1), 77]
    assert (one.view.observation[1] == other.view.observation[1]).all()
    assert one.state.stream[1] == level_stream(stream_base("yard", "dev"), 77)
    one.begin_next(both)
    assert one.state.level[:, 0].tolist() == [later_level(3, 2), later_level(4, 2)]


def test_a_level_that_is_begun_by_its_number_forgets_the_chosen_one() -> None:
    episodes = play(RANDOM)
    episodes.choose(np.array([0]), np.array([77]))
    episodes.begin(np.array([0]), np.array([5]))
    episodes.begin_next(np.array([0]))
    assert episodes.state.level.tolist() == [[later_level(5, 1)]]
