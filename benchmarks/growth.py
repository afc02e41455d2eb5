"""How the cost grows with the number of agents, obstacles, beams, worlds and threads."""

from __future__ import annotations

import time

import players
from effort import Effort, Figures
from standard_worlds import ORCA, crowd, s1, s3, s5

AGENTS = (10, 30, 100, 300, 1000, 3000, 10_000)
OBSTACLES = (10, 40, 160, 640)
PUSHED = (10, 30, 100)
BEAMS = (16, 60, 180, 360, 720, 1080)
WORLDS = (1, 4, 16, 64, 256, 1024, 4096)
THREADS = (1, 2)
BATCH = 64


def agents(effort: Effort) -> Figures:
    """Measure a crowd under ORCA at one density, per agent and step, in one world."""
    return {f"{n}_agents_us": effort.per_agent_us(players.crowd(crowd(ORCA, n))) for n in effort.sizes(AGENTS)}


def obstacles(effort: Effort) -> Figures:
    """Measure S1 with more obstacles in a larger room."""
    batch = min(BATCH, effort.largest or BATCH)
    return {f"{n}_obstacles_us": effort.per_agent_us(players.core(s1(n), batch)) for n in effort.sizes(OBSTACLES)}


def beams(effort: Effort) -> Figures:
    """Measure S1 with more beams."""
    batch = min(BATCH, effort.largest or BATCH)
    return {f"{n}_beams_us": effort.per_agent_us(players.core(s1(10, n), batch)) for n in effort.sizes(BEAMS)}


def worlds(effort: Effort) -> Figures:
    """Measure S1 with more worlds."""
    return {f"{n}_worlds_us": effort.per_agent_us(players.core(s1(), n)) for n in effort.sizes(WORLDS)}


def threads(effort: Effort) -> Figures:
    """Measure S1 and S3 on one and on two threads in turns: wall time, so that it says something when idle only."""
    figures: Figures = {}
    for n_worlds in effort.sizes((64, 1024)):
        for name, scenario in {"s1": s1(), "s3_cave": s3("cave")}.items():
            pair = {f"{n}_threads": players.core(scenario, n_worlds, n) for n in THREADS}
            timings = effort.in_turns_us(pair, time.perf_counter)
            figures |= {f"{name}_{n_worlds}_worlds_{key}_wall_us": timing for key, timing in timings.items()}
            one, two = (timings[f"{n}_threads"].least for n in THREADS)
            figures[f"{name}_{n_worlds}_worlds_2_threads_times_faster"] = one / two
    return figures


def pushed(effort: Effort) -> Figures:
    """Measure S5 with more bodies in a larger room."""
    batch = min(BATCH, effort.largest or BATCH)
    return {f"{n}_bodies_us": effort.per_agent_us(players.pushing(s5(n), batch)) for n in effort.sizes(PUSHED)}


GROWTH = {
    "growth/agents": agents,
    "growth/obstacles": obstacles,
    "growth/beams": beams,
    "growth/pushed": pushed,
    "growth/worlds": worlds,
    "growth/threads": threads,
}
