"""Crowds that avoid each other, at constant density; beside IR-SIM, where it is installed, on the same file."""

from __future__ import annotations

import importlib.util
import tempfile
from pathlib import Path
from typing import Any

import players
import yaml
from effort import Effort, Figures
from players import Player
from standard_worlds import RUN_STEPS, crowd

SIZES = (10, 100, 1000)
PEER_SIZES = (10, 100)
BATCH_SIZE, BATCH_WORLDS = 10, 256


def measure(behavior: dict[str, Any], effort: Effort) -> Figures:
    """Microseconds of CPU per agent and step, in turns with IR-SIM; the ratio is one of medians."""
    figures: Figures = {}
    for n_agents in effort.sizes(SIZES):
        scenario = crowd(behavior, n_agents)
        pair = {"": players.crowd(scenario)}
        if n_agents in PEER_SIZES and (theirs := _peer(scenario, n_agents)) is not None:
            pair["_irsim"] = theirs
        timings = effort.in_turns_us(pair)
        figures |= {f"{n_agents}_agents{who}_us": timing for who, timing in timings.items()}
        if len(pair) > 1:
            figures[f"{n_agents}_agents_times_faster"] = timings["_irsim"].median / timings[""].median
    if effort.largest is None:
        batch = players.crowd(crowd(behavior, BATCH_SIZE), BATCH_WORLDS)
        figures[f"{BATCH_SIZE}_agents_{BATCH_WORLDS}_worlds_us"] = effort.per_agent_us(batch)
    return figures


def _peer(scenario: dict[str, Any], n_agents: int) -> Player | None:
    if importlib.util.find_spec("irsim") is None:
        return None
    import irsim

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "crowd.yaml"
        file.write_text(yaml.safe_dump(scenario), encoding="utf-8")
        peer = irsim.make(str(file), display=False, log_level="ERROR")
    return Player(peer.step, n_agents, peer.reset, RUN_STEPS)
