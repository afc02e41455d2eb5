"""Random streams: known values, uniformity, and levels that never meet."""

from __future__ import annotations

import numpy as np
import pytest

from irsim_gym.base import rng

N = 20_000


def stream(split: str = "train", level: int = 0) -> np.ndarray:
    return np.array([rng.level_stream(rng.stream_base("room", split), level)], np.uint64)


def test_generator_is_splitmix64() -> None:
    # The first outputs of the published reference generator for the seed 1234567.
    state = np.array([1234567], np.uint64)
    expected = [6457827717110365317, 3203168211198807973, 9817491932198370423]
    assert [int(rng.next_bits(state, 0)) for _ in expected] == expected


def test_uniform_normal_and_integer_have_their_moments() -> None:
    state = stream()
    uniform = np.array([rng.uniform(state, 0, 2.0, 4.0) for _ in range(N)])
    assert uniform.min() >= 2.0
    assert uniform.max() < 4.0
    assert uniform.mean() == pytest.approx(3.0, abs=0.02)
    normal = np.array([rng.normal(state, 0, 1.0, 0.5) for _ in range(N)])
    assert normal.mean() == pytest.approx(1.0, abs=0.02)
    assert normal.std() == pytest.approx(0.5, abs=0.02)
    counts = np.bincount([rng.integer(state, 0, 0, 5) for _ in range(N)])
    assert len(counts) == 5
    assert np.all(np.abs(counts - N / 5) < 300)


def test_levels_of_all_splits_have_streams_of_their_own() -> None:
    streams = {int(stream(split, level)[0]) for split in ("train", "dev", "test") for level in range(3000)}
    assert len(streams) == 9000


def test_neighbouring_levels_are_not_correlated() -> None:
    first = np.array([rng.uniform(stream(level=level), 0, 0.0, 1.0) for level in range(N)])
    assert np.corrcoef(first[:-1], first[1:])[0, 1] == pytest.approx(0.0, abs=0.03)


def test_later_levels_lie_out_of_reach_of_seeds() -> None:
    assert rng.later_level(17, 0) == 17
    later = [int(rng.later_level(first, episode)) for first in range(200) for episode in range(1, 50)]
    assert len(set(later)) == len(later)
    assert min(later) >= 2**52
    assert max(later) < 2**53
