"""Run what others offer beside irsim_gym, on the same work, in the same run.

    python benchmarks/peers.py [-f REGEX] [--peer REGEX] [--json FILE] [--rounds N] [--tiny]

Each peer lives in a virtual environment of its own (``--cache``), because they want conflicting packages, and plays in
a process of its own, all on one core. Rounds take turns (A, B, C, A, B, C ...); a round is disturbed when the loops of
plain Python between its parts took more or less time than is usual in that process, and is played again. Who has too
few good rounds in the end keeps the least disturbed ones; the result says how many were played, rejected and kept so.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import results
import standard_worlds as worlds
from machine import describe
from processes import Player, environment, started, stop, take_turns
from rich.console import Console
from rich.table import Table
from timing import summed_up

HERE = Path(__file__).parent
CACHE = HERE.parent / "build" / "peers"
CONSTRAINTS = HERE.parent / "constraints.txt"
REQUIREMENTS: dict[str, tuple[str, ...]] = {
    "ours": (),
    "irsim": ("ir-sim==2.12.0",),
    "navground": ("navground==0.7.0",),
    "vmas": ("vmas==1.5.2", "torch"),
    "jaxnav": ("jaxmarl==0.2.0",),
}
"""What each needs; torch is pinned by constraints.txt, for a bare one pulls gigabytes."""

SIZES = {"ours": 1024, "vmas": 1024, "jaxnav": 64, "map": 64, "one": 1}
TINY_SIZES = {"ours": 2, "vmas": 2, "jaxnav": 2, "map": 2, "one": 1}
N_STARTS, N_LEVELS = 64, 8
CROWDS = (10, 100, 1000)

WORKS: dict[str, Mapping[str, Any]] = {
    "s1_single": {"scenario": worlds.s1()},
    "s1_batch": {"scenario": worlds.s1()},
    "s2_rvo": {"scenario": worlds.s2("rvo"), "n_steps": worlds.RUN_STEPS},
    "s2_orca": {"scenario": worlds.s2("orca"), "n_steps": worlds.RUN_STEPS},
    "s3_cave": {"scenario": worlds.s3("cave")},
    "s3_floor_plan": {"scenario": worlds.s3("floor_plan")},
    "s4": {"scenario": worlds.s4(), "n_steps": worlds.TEAM_STEPS},
    "s5": {"scenario": worlds.s5(), "n_steps": worlds.PUSH_STEPS},
    **{f"orca_{n}": {"scenario": worlds.crowd(worlds.ORCA, n), "n_steps": worlds.RUN_STEPS} for n in CROWDS},
}


def python_of(peer: str, cache: Path, pip_arguments: Sequence[str]) -> Path:
    """Return the interpreter of a peer's virtual environment, which is made on first use.

    Raises:
        subprocess.CalledProcessError: It cannot be installed.
    """
    if peer == "ours":
        return Path(sys.executable)
    folder, wanted = cache / peer, "\n".join(REQUIREMENTS[peer])
    python, stamp = folder / "bin" / "python", folder / ".installed"
    if not stamp.exists() or stamp.read_text(encoding="utf-8") != wanted:
        _run([sys.executable, "-m", "venv", "--clear", "--without-pip", str(folder)])
        pip = [sys.executable, "-m", "pip", "--python", str(python), "--disable-pip-version-check", "--quiet"]
        _run([*pip, "install", "-c", str(CONSTRAINTS), *pip_arguments, *REQUIREMENTS[peer]])
        stamp.write_text(wanted, encoding="utf-8")
    return python


def _run(command: Sequence[str]) -> None:
    subprocess.run(command, check=True, capture_output=True, text=True)


def about(peer: str) -> dict[str, Any]:
    """Return what a peer says of itself; its package need not be there."""
    command = [sys.executable, str(HERE / "peers" / f"{peer}_peer.py"), "--describe"]
    said = subprocess.run(command, check=True, capture_output=True, text=True, env=environment())
    found: dict[str, Any] = json.loads(said.stdout)
    return found


def starts_of(scenario: Mapping[str, Any]) -> list[list[float]]:
    """Return x, y, heading and the goal's x, y of the learner in the first levels, as our environments draw them."""
    if "task" not in scenario or has_levels(scenario):
        return []
    state = drawn(scenario, N_STARTS).simulation.state
    pairs = zip(state.pose[:, 0].tolist(), state.goal[:, 0, :2].tolist(), strict=True)
    return [[*pose, *goal] for pose, goal in pairs]


def levels_of(scenario: Mapping[str, Any]) -> list[list[list[float]]]:
    """Return x, y, heading of every body in the first levels, as our environments draw them, where bodies move."""
    if "task" not in scenario or not has_levels(scenario):
        return []
    levels: list[list[list[float]]] = drawn(scenario, N_LEVELS).simulation.state.pose.tolist()
    return levels


def is_team(scenario: Mapping[str, Any]) -> bool:
    """Return whether several robots learn."""
    return bool(scenario["robot"][0].get("number", 1) > 1)


def has_levels(scenario: Mapping[str, Any]) -> bool:
    """Return whether all bodies have to be put back at the start of a level."""
    return is_team(scenario) or scenario["world"].get("collision_mode") == "contact"


def drawn(scenario: Mapping[str, Any], count: int) -> Any:
    """Return our worlds at the first levels."""
    from irsim_gym.envs import Worlds

    found = Worlds(scenario, count, team=is_team(scenario))
    found.begin(range(count), range(count), [{}] * count, lambda w: w)
    return found


def measure(work: str, pythons: Mapping[str, Path], ways: Mapping[str, list[str]], asked: Any) -> list[Player]:
    """Play one work with all who can, in turns."""
    scenario = WORKS[work]["scenario"]
    given = {**WORKS[work], "starts": starts_of(scenario), "levels": levels_of(scenario), "round_s": asked.round_s}
    given["sizes"] = TINY_SIZES if asked.tiny else SIZES
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        file = folder / "given.json"
        file.write_text(json.dumps(given), encoding="utf-8")
        players = []
        for peer, names in ways.items():
            for name in names:
                said = stack.enter_context((folder / f"{peer}-{name}.txt").open("w+", encoding="utf-8"))
                player = started(peer, name, pythons[peer], file, said)
                stack.callback(stop, player.process)
                ready = player.answer()
                player.version = ready.get("version")
                player.poses = ready.get("poses", [])
                players.append(player)
        take_turns(players, asked.rounds)
    return players


def figures_of(players: Sequence[Player]) -> tuple[dict[str, float], dict[str, float]]:
    """Return figures and noise of all who played to the end: least, median, and how much slower than ours it is."""
    figures, noise = {}, {}
    timings = {player.name: summed_up(player.values) for player in players if player.values and not player.failure}
    for name, timing in timings.items():
        figures[f"{name}_us"] = timing.least
        figures[f"{name}_median_us"] = timing.median
        noise[f"{name}_us"] = noise[f"{name}_median_us"] = timing.noise
    if "ours" in timings:
        for name, timing in timings.items():
            if not name.startswith("ours"):
                figures[f"{name}_times_slower"] = timing.median / timings["ours"].median
    figures |= {f"{name}_apart_m": apart for name, apart in apart_m(players).items()}
    return figures, noise


def apart_m(players: Sequence[Player]) -> dict[str, float]:
    """Return how far from ours the agents of others are after a run, at most [m]; of those who tell."""
    ours = next((player.poses for player in players if player.name == "ours"), [])
    return {
        player.name: max(math.dist(a, b) for a, b in zip(player.poses, ours, strict=True))
        for player in players
        if ours and player.poses and not player.name.startswith("ours")
    }


def main() -> None:
    """Install, play, show and write down."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-f", "--filter", default="", help="only the works whose names match")
    parser.add_argument("--peer", default="", help="only the peers whose names match")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    parser.add_argument("--rounds", type=int, default=7, help="good rounds of each")
    parser.add_argument("--round-s", type=float, default=0.4, help="CPU seconds of a round")
    parser.add_argument("--cache", type=Path, default=CACHE, help="folder of the virtual environments")
    parser.add_argument("--pip-args", default=os.environ.get("PIP_ARGS", ""), help="passed on to pip")
    parser.add_argument("--tiny", action="store_true", help="one short round each: to see that all run")
    asked = parser.parse_args()
    if asked.tiny:
        asked.rounds, asked.round_s = 1, 0.0
    console, machine = Console(), describe()
    told, pythons = {}, {}
    for peer in (name for name in REQUIREMENTS if name == "ours" or re.search(asked.peer, name)):
        told[peer] = about(peer)
        with console.status(f"installing {peer}"):
            try:
                pythons[peer] = python_of(peer, asked.cache.resolve(), asked.pip_args.split())
            except subprocess.CalledProcessError as error:
                lines = str(error.stderr or error).strip().splitlines()
                told[peer]["missing"] = f"not installed: {lines[-1] if lines else error}"
    result: dict[str, Any] = {"machine": machine, "results": {}, "noise": {}, "peers": told, "rounds": {}, "took_s": {}}
    for work in (name for name in WORKS if re.search(asked.filter, name)):
        ways = {peer: [way for way in told[peer]["works"] if way.partition("@")[0] == work] for peer in pythons}
        begin = time.perf_counter()
        with console.status(work):
            players = measure(work, pythons, ways, asked)
        result["took_s"][work] = round(time.perf_counter() - begin, 1)
        _note(work, players, result)
        _show(work, result, players, console)
        if asked.json:
            results.write(asked.json, result)
    for peer, said in told.items():
        if "missing" in said:
            console.print(f"[red]{peer}: {said['missing']}")


def _note(work: str, players: Sequence[Player], result: dict[str, Any]) -> None:
    result["results"][work], result["noise"][work] = figures_of(players)
    result["rounds"][work] = {player.name: player.counts() for player in players}
    for player in players:
        peer = result["peers"][player.name.split("_")[0]]
        peer["version"] = player.version or peer["version"]
        if player.failure:
            peer.setdefault("failures", {})[f"{work} {player.name}"] = player.failure


def _show(work: str, result: dict[str, Any], players: Sequence[Player], console: Console) -> None:
    table = Table("who", "us", "median", "times slower", title=work)
    figures = result["results"][work]
    for player in players:
        least, median = figures.get(f"{player.name}_us"), figures.get(f"{player.name}_median_us")
        times = figures.get(f"{player.name}_times_slower")
        cells = ["" if value is None else f"{value:.4g}" for value in (least, median, times)]
        table.add_row(player.name, *cells if not player.failure else (player.failure, "", ""))
    console.print(table)


if __name__ == "__main__":
    main()
