"""Arrays cannot lie about their declaration, and records hold what kernels read."""

from __future__ import annotations

import struct
from typing import Literal

import numpy as np
import pytest

import irsim_gym
from irsim_gym.base.options import kind, option
from irsim_gym.simulator.world import arrays
from irsim_gym.simulator.world.group import records
from irsim_gym.simulator.world.model import Model
from irsim_gym.simulator.world.state import State
from irsim_gym.tasks.terms.episode_state import EpisodeState

SIZES = {
    "world": 3,
    "body": 2,
    "segment": 5,
    "disc": 1,
    "waypoint": 4,
    "watching": 1,
    "bucket": 1,
    "map_column": 1,
    "map_row": 1,
    "map_box": 1,
}


@pytest.mark.parametrize("declared", [Model, State])
def test_every_array_is_declared_with_a_meaning(declared: type[Model] | type[State]) -> None:
    made = declared.allocate(SIZES)
    for name, column in declared.columns().items():
        array = getattr(made, name)
        assert column.meaning
        assert array.dtype == column.dtype
        assert array.ndim == len(column.axes)
        assert array.flags.c_contiguous


def test_shared_axes_have_one_row_unless_asked_for() -> None:
    shared, own = Model.allocate(SIZES), Model.allocate(SIZES, per_world=frozenset({"local_segments"}))
    assert shared.local_segments.shape == (1, 5, 4)
    assert own.local_segments.shape == (3, 5, 4)
    assert own.present.shape == (3, 2)


def test_arrays_that_belong_together_lie_in_memory_as_a_c_struct_does() -> None:
    """Groups are rows of one block; every group begins where its type may, right behind the one before."""
    sizes = {"world": 3, "agent": 1, "action": 2, "ending": 1, "reward": 2, "feature": 5, "extra": 1}
    state = EpisodeState.allocate(sizes)
    layout, first = "@", getattr(state, EpisodeState.together[0][0])
    for names in EpisodeState.together:
        for name in names:
            array = getattr(state, name)
            layout += f"0{array.dtype.char}"
            assert array.ctypes.data - first.ctypes.data == struct.calcsize(layout), name
            layout += f"{array.size}{array.dtype.char}"
            assert array.base is first.base
            assert not array.any()


@kind
class Options:
    """Options of every type that records know."""

    radius: float = option(1.0, meaning="A number.")
    wheelbase: float | None = option(None, meaning="A number or nothing.")
    count: int = option(3, meaning="A count.")
    active: bool = option(True, meaning="A flag.")
    mode: Literal["slow", "fast"] = option("fast", meaning="A choice.")
    bounds: tuple[float, float] = option((0.0, 1.0), meaning="A pair.")
    label: str = option("text", meaning="Not for kernels.")
    vertices: tuple[tuple[float, float], ...] | None = option(None, meaning="Not for kernels.")


def test_records_hold_numbers_choices_and_pairs() -> None:
    table = records([Options(), Options(radius=2.0, wheelbase=0.5, active=False, mode="slow", bounds=(3.0, 4.0))])
    assert table.dtype.names == ("index", "radius", "wheelbase", "count", "active", "mode", "bounds")
    assert table[1].radius == 2.0
    assert np.isnan(table[0].wheelbase)
    assert table[1].wheelbase == 0.5
    assert table["count"].tolist() == [3, 3]
    assert table["active"].tolist() == [1, 0]
    assert table["mode"].tolist() == [1, 0]
    assert table[1].bounds.tolist() == [3.0, 4.0]


def test_more_worlds_than_there_is_memory_for_are_refused_beforehand(monkeypatch: pytest.MonkeyPatch) -> None:
    """One world of these takes some kilobytes; the system would grant far more than there is, and kill later."""
    monkeypatch.setattr(arrays, "total_memory", lambda: 10**8)
    State.allocate({**SIZES, "world": 100})
    with pytest.raises(MemoryError, match=r"10,000,000 worlds .* need at least [\d.,]+ GB .* has 0\.1 GB"):
        State.allocate({**SIZES, "world": 10_000_000})
    monkeypatch.setattr(arrays, "total_memory", lambda: None)
    State.allocate(SIZES)


def test_a_batch_has_at_least_one_world() -> None:
    with pytest.raises(ValueError, match="num_envs must be a whole number >= 1, got 0"):
        irsim_gym.make_vec("empty_goal", num_envs=0)
