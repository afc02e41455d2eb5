"""Run what others offer beside irsim_gym, on the same work, in the same run.

    python benchmarks/peers.py [-f REGEX] [--peer REGEX] [--json FILE] [--rounds N] [--tiny]

Each peer lives in a virtual environment of its own (``--cache``), because they want conflicting packages, and plays in
a process of its own. Rounds take turns (A, B, C, A, B, C ...); a round whose loop of plain Python took much longer than
the fastest one was disturbed and is played again.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import threading
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import results
import standard_worlds as worlds
from machine import describe
from rich.console import Console
from rich.table import Table
from timing import is_disturbed, summed_up

HERE = Path(__file__).parent
CACHE = HERE.parent / "build" / "peers"
CONSTRAINTS = HERE.parent / "constraints.txt"
PATIENCE = 900.0
"""Seconds after which a process that does not answer is given up."""

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
N_STARTS = 64
CROWDS = (10, 100, 1000)

WORKS: dict[str, Mapping[str, Any]] = {
    "s1_single": {"scenario": worlds.s1()},
    "s1_batch": {"scenario": worlds.s1()},
    "s2_rvo": {"scenario": worlds.s2("rvo"), "n_steps": worlds.RUN_STEPS},
    "s2_orca": {"scenario": worlds.s2("orca"), "n_steps": worlds.RUN_STEPS},
    "s3_cave": {"scenario": worlds.s3("cave")},
    "s3_floor_plan": {"scenario": worlds.s3("floor_plan")},
    "s4": {"scenario": worlds.s4()},
    **{f"orca_{n}": {"scenario": worlds.crowd(worlds.ORCA, n), "n_steps": worlds.RUN_STEPS} for n in CROWDS},
}


@dataclass
class Player:
    """A process that plays one work in one way.

    Attributes:
        name: Peer and, where there are several, the way: ``ours_core``.
        process: The process.
        version: Of the peer's package.
        values: Microseconds of CPU per agent and step of the good rounds.
        rejected: Rounds that were disturbed.
        failure: Why it does not play; empty while it does.
    """

    name: str
    process: subprocess.Popen[str]
    version: str | None = None
    values: list[float] = field(default_factory=list)
    rejected: int = 0
    failure: str = ""

    def answer(self) -> dict[str, Any]:
        """Return the next line that the process says; empty, with ``failure`` set, when it has died or hangs."""
        assert self.process.stdout is not None
        assert self.process.stderr is not None
        watch = threading.Timer(PATIENCE, self.process.kill)
        watch.start()
        line = self.process.stdout.readline()
        watch.cancel()
        if line:
            found: dict[str, Any] = json.loads(line)
            return found
        self.process.wait()
        said = self.process.stderr.seek(0) or self.process.stderr.read()
        self.failure = next((text for text in reversed(str(said).splitlines()) if text.strip()), "it said nothing")
        return {}

    def play(self) -> dict[str, Any]:
        """Ask for one round and return its answer."""
        assert self.process.stdin is not None
        with suppress(BrokenPipeError):
            self.process.stdin.write("\n")
            self.process.stdin.flush()
        return self.answer()


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
        _run([sys.executable, "-m", "venv", "--clear", str(folder)])
        pip = [str(python), "-m", "pip", "install", "--disable-pip-version-check", "--quiet", "-c", str(CONSTRAINTS)]
        _run([*pip, *pip_arguments, *REQUIREMENTS[peer]])
        stamp.write_text(wanted, encoding="utf-8")
    return python


def _run(command: Sequence[str]) -> None:
    subprocess.run(command, check=True, capture_output=True, text=True)


def about(peer: str) -> dict[str, Any]:
    """Return what a peer says of itself; its package need not be there."""
    command = [sys.executable, str(HERE / "peers" / f"{peer}_peer.py"), "--describe"]
    said = subprocess.run(command, check=True, capture_output=True, text=True, env=_environment())
    found: dict[str, Any] = json.loads(said.stdout)
    return found


def _environment() -> dict[str, str]:
    paths = [str(HERE), str(HERE / "peers"), str(HERE.parent), os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in paths if path), "PYTHONWARNINGS": "ignore"}


def starts_of(scenario: Mapping[str, Any]) -> list[list[float]]:
    """Return x, y, heading and the goal's x, y of the learner in the first levels, as our environments draw them."""
    from irsim_gym.envs.worlds import Worlds

    if "task" not in scenario or scenario["robot"][0].get("number", 1) > 1:
        return []
    drawn = Worlds(scenario, N_STARTS)
    drawn.begin(range(N_STARTS), range(N_STARTS), [{}] * N_STARTS, lambda w: w)
    state = drawn.simulation.state
    pairs = zip(state.pose[:, 0].tolist(), state.goal[:, 0, :2].tolist(), strict=True)
    return [[*pose, *goal] for pose, goal in pairs]


def measure(work: str, pythons: Mapping[str, Path], ways: Mapping[str, list[str]], asked: Any) -> list[Player]:
    """Play one work with all who can, in turns."""
    given = {**WORKS[work], "starts": starts_of(WORKS[work]["scenario"]), "round_s": asked.round_s}
    given["sizes"] = TINY_SIZES if asked.tiny else SIZES
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        file = folder / "given.json"
        file.write_text(json.dumps(given), encoding="utf-8")
        players = []
        for peer, names in ways.items():
            for name in names:
                said = stack.enter_context((folder / f"{peer}-{name}.txt").open("w+", encoding="utf-8"))
                player = _started(peer, name, pythons[peer], file, said)
                stack.callback(_stop, player.process)
                player.version = player.answer().get("version")
                players.append(player)
        _take_turns(players, asked.rounds)
    return players


def _started(peer: str, name: str, python: Path, given: Path, said: Any) -> Player:
    command = [str(python), str(HERE / "peers" / f"{peer}_peer.py"), name, str(given)]
    process = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=said, text=True, env=_environment()
    )
    process.stderr = said
    _, _, way = name.partition("@")
    return Player(f"{peer}_{way}" if way else peer, process)


def _take_turns(players: Sequence[Player], rounds: int) -> None:
    """Ask for rounds in turns until each has enough good ones; a disturbed one is played again, up to a limit."""
    least = float("inf")
    kept: list[tuple[Player, float, float]] = []
    for _ in range(3 * rounds):
        for player in players:
            if player.failure or sum(one is player and not is_disturbed(c, least) for one, _, c in kept) >= rounds:
                continue
            found = player.play()
            if found:
                least = min(least, found["calibration_s"])
                kept.append((player, found["us"], found["calibration_s"]))
    for player, us, calibration_s in kept:
        if is_disturbed(calibration_s, least):
            player.rejected += 1
        else:
            player.values.append(us)
    for player in players:
        if not player.failure and len(player.values) < rounds:
            player.failure = f"disturbed: {len(player.values)} of {rounds} rounds were good"


def _stop(process: subprocess.Popen[str]) -> None:
    assert process.stdin is not None
    with suppress(BrokenPipeError):
        process.stdin.close()
    try:
        process.wait(timeout=10.0)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    if process.stdout is not None:
        process.stdout.close()


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
    return figures, noise


def main() -> None:
    """Install, play, show and write down."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-f", "--filter", default="", help="only the works whose names match")
    parser.add_argument("--peer", default="", help="only the peers whose names match")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    parser.add_argument("--rounds", type=int, default=7, help="good rounds of each")
    parser.add_argument("--round-s", type=float, default=0.5, help="CPU seconds of a round")
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
    result: dict[str, Any] = {"machine": machine, "results": {}, "noise": {}, "peers": told, "rejected_rounds": 0}
    for work in (name for name in WORKS if re.search(asked.filter, name)):
        ways = {peer: [way for way in told[peer]["works"] if way.partition("@")[0] == work] for peer in pythons}
        with console.status(work):
            players = measure(work, pythons, ways, asked)
        _note(work, players, result)
        _show(work, result, players, console)
        if asked.json:
            results.write(asked.json, result)
    for peer, said in told.items():
        if "missing" in said:
            console.print(f"[red]{peer}: {said['missing']}")


def _note(work: str, players: Sequence[Player], result: dict[str, Any]) -> None:
    result["results"][work], result["noise"][work] = figures_of(players)
    for player in players:
        result["rejected_rounds"] += player.rejected
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
