"""irsim_gym itself, and the twin of S1 in C."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from worker import Peer, Play, Work, serve


def _play(name: str, sized: str | None = None) -> Callable[[Mapping[str, Any]], Play]:
    """Return what builds one of ``players``; ``sized`` names the entry of ``sizes`` with the number of worlds."""
    return partial(_built, name, sized)


def _built(name: str, sized: str | None, given: Mapping[str, Any]) -> Play:
    import players

    sizes = () if sized is None else (given["sizes"][sized],)
    arguments = sizes if name == "twin" else (given["scenario"], *sizes)
    found = getattr(players, name)(*arguments)
    return Play(found.step, found.n_agents, found.rewind, found.n_steps, found.places)


TWIN = ("S1 without an interface", "starts are drawn without a check for a path to the goal")

PEER = Peer(
    "ours",
    "irsim_gym",
    {
        "s1_single": Work(_play("single")),
        "s1_single@twin": Work(_play("twin", "one"), TWIN),
        "s1_batch": Work(_play("vector", "ours")),
        "s1_batch@vec_env": Work(_play("vec_env", "ours")),
        "s1_batch@core": Work(_play("core", "ours")),
        "s1_batch@twin": Work(_play("twin", "ours"), TWIN),
        "s2_rvo": Work(_play("crowd")),
        "s2_rvo@batch": Work(_play("crowd", "map")),
        "s2_orca": Work(_play("crowd")),
        "s2_orca@batch": Work(_play("crowd", "map")),
        "s3_cave": Work(_play("vector", "map")),
        "s3_cave@single": Work(_play("single")),
        "s3_floor_plan": Work(_play("vector", "map")),
        "s3_floor_plan@single": Work(_play("single")),
        "s4": Work(_play("team", "ours")),
        "s4@single": Work(_play("team", "one")),
        "s5": Work(_play("pushing", "ours")),
        "s5@single": Work(_play("single")),
        **{f"orca_{n}": Work(_play("crowd")) for n in (10, 100, 1000)},
    },
)

if __name__ == "__main__":
    serve(PEER)
