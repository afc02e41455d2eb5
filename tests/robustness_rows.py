"""Results of `irsim-gym robustness` that are made by hand."""

from __future__ import annotations

from irsim_gym.evaluation import Robustness, StrengthRow
from irsim_gym.evaluation.measures.metrics import rate

ROOM = "cluttered_room"


def made(policy: str, *successes: int, of: int = 100) -> list[StrengthRow]:
    """Return rows of a policy with latencies of 0, 0.2, 0.4 s and so on."""
    none = rate(0, of)
    factors = ("undisturbed", *["latency"] * (len(successes) - 1))
    named = [(factor, 0.2 * k, "s", "", 0.0, policy) for k, factor in enumerate(factors)]
    return [StrengthRow(*row, rate(count, of), none) for row, count in zip(named, successes, strict=True)]


def result(*rows: StrengthRow) -> Robustness:
    return Robustness({"scenario": ROOM, "levels": 100, "split": "test"}, list(rows))
