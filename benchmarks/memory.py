"""Bytes that worlds take."""

from __future__ import annotations

import gc
import tracemalloc
from collections.abc import Mapping
from typing import Any

import players
from effort import Effort, Figures
from standard_worlds import s1, s3, s4

FEW, MANY = 16, 272


def memory(effort: Effort) -> Figures:
    """Measure what each further world takes, and what the first ones share, in KiB; nothing in it is a time."""
    figures: Figures = {}
    most = effort.sizes((FEW + 1, MANY))[-1]
    for name, scenario in {"s1": s1(), "s3_cave": s3("cave"), "s4": s4()}.items():
        players.core(scenario, 1, team=name == "s4").step()
        few, many = (_kib(scenario, n, name == "s4") for n in (FEW, most))
        each = (many - few) / (most - FEW)
        figures[f"{name}_world_kib"] = each
        figures[f"{name}_shared_kib"] = few - FEW * each
    return figures


def _kib(scenario: Mapping[str, Any], n_worlds: int, is_team: bool) -> float:
    gc.collect()
    tracemalloc.start()
    try:
        player = players.core(scenario, n_worlds, team=is_team)
        player.step()
        gc.collect()
        return tracemalloc.get_traced_memory()[0] / 1024.0
    finally:
        tracemalloc.stop()
