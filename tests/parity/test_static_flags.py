"""Flags of bodies that never move, at the start of an episode: those of ir-sim's reset()."""

from __future__ import annotations

from pathlib import Path

import pytest
from cases import case_of
from harness import Pair
from ir_sim import silent


@pytest.mark.parametrize("mode", ["stop", "unobstructed_obstacles", "unobstructed"])
def test_what_overlaps_and_never_moves_has_its_flags_from_the_start(mode: str, tmp_path: Path) -> None:
    case = case_of("collisions/what_is_hit_and_never_moves")
    pair = Pair({**case, "world": {"collision_mode": mode}}, tmp_path)
    pair.step_both(0)
    with silent():
        pair.reference.env.reset()
    pair.sim.reset(seed=0)
    flags = [one[1:] for one in pair.reference.snapshot().flags]
    state = pair.sim.state
    assert list(zip(state.collided[0].tolist(), state.stopped[0].tolist(), strict=True)) == flags
    assert flags[4:6] == [(True, mode == "stop")] * 2
