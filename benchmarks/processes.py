"""Processes that play a work, and their rounds, which take turns."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import threading
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from timing import DISTURBED, off

HERE = Path(__file__).parent
RETRIES = 5
"""Rounds that may be played again because they were disturbed, of each player and work."""

PATIENCE = 900.0
"""Seconds after which a process that does not answer is given up."""


@dataclass
class Player:
    """A process that plays one work in one way.

    Attributes:
        name: Peer and, where there are several, the way: ``ours_core``.
        process: The process.
        version: Of the peer's package.
        rounds: Microseconds of CPU per agent and step of each round, and seconds of its calibration.
        wanted: How many rounds count; all good ones where there are fewer.
        poses: x, y of its agents after a run [m]; empty where there is nothing to compare.
        failure: Why it does not play; empty while it does.
    """

    name: str
    process: subprocess.Popen[str]
    version: str | None = None
    rounds: list[tuple[float, float]] = field(default_factory=list)
    wanted: int = 1
    poses: list[list[float]] = field(default_factory=list)
    failure: str = ""

    @property
    def off(self) -> list[float]:
        """By what share the calibration of each round is off from what is usual in this process."""
        return off([calibration_s for _, calibration_s in self.rounds])

    @property
    def good(self) -> int:
        """Rounds that were not disturbed."""
        return sum(one <= DISTURBED for one in self.off)

    @property
    def values(self) -> list[float]:
        """Microseconds of the rounds that count: the good ones, or the least disturbed ones where those are too few."""
        kept = max(self.good, min(self.wanted, len(self.rounds)))
        worst = sorted(max(one, DISTURBED) for one in self.off)[kept - 1] if kept else 0.0
        return [us for (us, _), one in zip(self.rounds, self.off, strict=True) if one <= worst]

    def counts(self) -> dict[str, float]:
        """Return how many rounds were played, rejected and kept though disturbed, and the calibration's median [us]."""
        kept, loops = len(self.values), [calibration_s for _, calibration_s in self.rounds]
        found = {"played": len(self.rounds), "rejected": len(self.rounds) - kept, "disturbed": kept - self.good}
        return found | ({"calibration_us": 1e6 * statistics.median(loops)} if loops else {})

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


def started(peer: str, name: str, python: Path, given: Path, said: Any) -> Player:
    """Return a peer that begins to build a work; what it says beside its answers goes to the file ``said``."""
    command = [str(python), str(HERE / "peers" / f"{peer}_peer.py"), name, str(given)]
    process = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=said, text=True, env=environment()
    )
    process.stderr = said
    _, _, way = name.partition("@")
    return Player(f"{peer}_{way}" if way else peer, process)


def take_turns(players: Sequence[Player], rounds: int) -> None:
    """Ask for rounds in turns until each has enough good ones; a disturbed one is played again, up to a limit."""
    for player in players:
        player.wanted = rounds
    for _ in range(rounds + RETRIES):
        for player in players:
            if not player.failure and player.good < rounds and (found := player.play()):
                player.rounds.append((found["us"], found["calibration_s"]))


def stop(process: subprocess.Popen[str]) -> None:
    """End a process."""
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


def environment() -> dict[str, str]:
    """Return the environment variables of a peer's process."""
    paths = [str(HERE), str(HERE / "peers"), str(HERE.parent), os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in paths if path), "PYTHONWARNINGS": "ignore"}
