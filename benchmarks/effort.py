"""How much a benchmark does: in earnest, or just enough to see that it runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from players import Player
from timing import Timing, cost, seconds, summed_up

Figures = dict[str, float | Timing]
"""Figures by name; names end with their unit."""

MOST_STEPS = 100_000


@dataclass(frozen=True)
class Effort:
    """How much is done.

    Attributes:
        rounds: Measurements of each figure.
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
        taken = seconds(step)
        return max(1, min(MOST_STEPS, int(self.round_s / taken))) if taken > 0.0 else 1

    def per_agent_us(self, player: Player, n_steps: int | None = None) -> Timing:
        """Return CPU microseconds per agent and step."""
        count = n_steps or self.steps(player.step)
        timing = cost(lambda: repeat(player.step, count), self.rounds, before=player.rewind)
        return timing.times(1e6 / count / player.n_agents)

    def in_turns_us(self, players: dict[str, Player]) -> dict[str, Timing]:
        """Return CPU microseconds per agent and step of several players, whose rounds take turns."""
        counts = {name: self.steps(player.step) for name, player in players.items()}
        values: dict[str, list[float]] = {name: [] for name in players}
        for _ in range(self.rounds):
            for name, player in players.items():
                taken = seconds(lambda player=player, count=counts[name]: repeat(player.step, count))
                values[name].append(1e6 * taken / counts[name] / player.n_agents)
        return {name: summed_up(found) for name, found in values.items()}


FULL = Effort(rounds=9, round_s=0.25)
TINY = Effort(rounds=1, round_s=0.0, largest=1)


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
