"""S1 through every interface, S2 to S5."""

from __future__ import annotations

from functools import partial

import c_twin
import players
from effort import Effort, Figures
from standard_worlds import s1, s2, s3, s4, s5

BATCHES = (1, 16, 64, 256, 1024, 4096)
LARGE = 1024
"""The batch at which interfaces are judged by what they cost above the core."""


def s1_faces(effort: Effort) -> Figures:
    """Measure S1 as a single environment and as batches, through each interface; they take turns."""
    scenario = s1()
    figures: Figures = {"single_us": effort.per_agent_us(players.single(scenario))}
    for n_worlds in effort.sizes(BATCHES):
        faces = {
            "core": players.core(scenario, n_worlds),
            "vector_env": players.vector(scenario, n_worlds),
            "vec_env": players.vec_env(scenario, n_worlds),
        }
        timings = effort.in_turns_us(faces)
        figures |= {f"{name}_{n_worlds}_worlds_us": timing for name, timing in timings.items()}
        if n_worlds == LARGE:
            for name in ("vector_env", "vec_env"):
                figures[f"{name}_above_core_us"] = max(0.0, timings[name].least - timings["core"].least)
    return figures


def s1_twin(effort: Effort) -> Figures:
    """Measure S1's core in turns with its C twin; the ratio is one of the least times. Nothing without a compiler."""
    figures: Figures = {}
    if c_twin.compiler() is None:
        return figures
    for n_worlds in effort.sizes(BATCHES):
        pair = effort.in_turns_us({"core": players.core(s1(), n_worlds), "twin": players.twin(n_worlds)})
        figures |= {f"{name}_{n_worlds}_worlds_us": timing for name, timing in pair.items()}
        figures[f"core_{n_worlds}_worlds_over_twin"] = pair["core"].least / pair["twin"].least
    return figures


def s2_swap(behavior: str, effort: Effort) -> Figures:
    """Measure robots that change sides, per robot and step, from the start until they have passed each other."""
    return {
        f"{n_worlds}_worlds_us": effort.per_agent_us(players.crowd(s2(behavior), n_worlds))
        for n_worlds in effort.sizes((1, 256))
    }


def s3_map(picture: str, effort: Effort) -> Figures:
    """Measure one robot in a map, alone and in batches."""
    scenario = s3(picture)
    figures: Figures = {"single_us": effort.per_agent_us(players.single(scenario))}
    for n_worlds in effort.sizes((1, 64, 1024)):
        figures[f"core_{n_worlds}_worlds_us"] = effort.per_agent_us(players.core(scenario, n_worlds))
    return figures


def s4_team(effort: Effort) -> Figures:
    """Measure teams among wanderers, per robot and step."""
    return {
        f"core_{n_worlds}_worlds_us": effort.per_agent_us(players.team(s4(), n_worlds))
        for n_worlds in effort.sizes((1, 64, 1024))
    }


def s5_pushing(effort: Effort) -> Figures:
    """Measure a robot that pushes bodies, per step."""
    return {
        f"core_{n_worlds}_worlds_us": effort.per_agent_us(players.pushing(s5(), n_worlds))
        for n_worlds in effort.sizes((1, 64, 1024))
    }


FACES = {
    "s1/faces": s1_faces,
    "s1/twin": s1_twin,
    "s2/rvo": partial(s2_swap, "rvo"),
    "s2/orca": partial(s2_swap, "orca"),
    "s3/cave": partial(s3_map, "cave"),
    "s3/floor_plan": partial(s3_map, "floor_plan"),
    "s4": s4_team,
    "s5": s5_pushing,
}
