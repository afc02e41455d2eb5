"""How much a benchmark does: in earnest, or just enough to see that it runs."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from players import Player
from timing import Timing, seconds, summed_up

Figures = dict[str, float | Timing]
"""Figures by name; names end with their unit."""

MOST_STEPS = 100_000
MOST_RUNS = 1000
LEAST_ROUNDS = 5
LONG_S = 5.0


@dataclass(frozen=True)
class Effort:
    """How much is done.

    Attributes:
        rounds: Measurements of each figure; ``LEAST_ROUNDS`` where all of them would take longer than ``LONG_S``.
        round_s: CPU time that a round should take at least [s].
        largest: Sizes above it are left out; None for no limit.
    """

    rounds: int
    round_s: float
    largest: int | None = None

    def sizes(self, wanted: Iterable[int]) -> list[int]:
        """Return the sizes that are measured: always the first one."""
        first, *others = wanted
        return [first, *(size for size in others if self.largest is None or size <= self.largest)]

    def steps(self, step: Callable[[], Any]) -> int:
        """Return how many steps make a round, from the time of one."""
        step()
        return self._fitting(seconds(step), MOST_STEPS)

    def per_agent_us(self, player: Player) -> Timing:
        """Return CPU microseconds per agent and step."""
        return self.in_turns_us({"": player})[""]

    def in_turns_us(
        self, players: Mapping[str, Player], clock: Callable[[], float] = time.process_time
    ) -> dict[str, Timing]:
        """Return microseconds of CPU, or of another clock, per agent and step of several players; rounds take turns."""
        sizes = {name: self._sizes(player) for name, player in players.items()}
        values: dict[str, list[float]] = {name: [] for name in players}
        begin = time.perf_counter()
        for k in range(self.rounds):
            if k >= LEAST_ROUNDS and time.perf_counter() - begin > LONG_S * len(players):
                break
            for name, player in players.items():
                n_steps, n_runs = sizes[name]
                taken = sum(run_s(player, n_steps, clock) for _ in range(n_runs))
                values[name].append(1e6 * taken / (n_steps * n_runs * player.n_agents))
        return {name: summed_up(found) for name, found in values.items()}

    def _sizes(self, player: Player) -> tuple[int, int]:
        """Return steps of a run and runs of a round."""
        if not player.n_steps:
            return self.steps(player.step), 1
        n_steps = player.n_steps if self.round_s else 1
        run_s(player, 1)
        return n_steps, self._fitting(run_s(player, n_steps), MOST_RUNS)

    def _fitting(self, taken: float, most: int) -> int:
        return max(1, min(most, int(self.round_s / taken))) if taken > 0.0 else 1


FULL = Effort(rounds=7, round_s=0.15)
TINY = Effort(rounds=1, round_s=0.0, largest=1)


def run_s(player: Player, n_steps: int, clock: Callable[[], float] = time.process_time) -> float:
    """Return the seconds of so many steps, of CPU or by another clock, from the start where the player has one."""
    if player.rewind is not None:
        player.rewind()
    return seconds(lambda: repeat(player.step, n_steps), clock)


def repeat(step: Callable[[], Any], count: int) -> None:
    """Step so many times."""
    for _ in range(count):
        step()


def flatten(figures: Figures) -> Iterator[tuple[str, float, float | None]]:
    """Yield name, value and noise of each figure; the noise of a plain number is not known."""
    for name, figure in figures.items():
        if isinstance(figure, Timing):
            yield name, figure.least, figure.noise
        else:
            yield name, float(figure), None
