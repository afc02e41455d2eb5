"""Several scenarios that one policy learns together: their notation, and their shares of the worlds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from irsim_gym.errors import IrsimGymError

SHARE = "share"
"""Name of the option with a scenario's weight."""


@dataclass(frozen=True)
class MixturePart:
    """One scenario of a mixture.

    Attributes:
        scenario: Shipped name, environment id, or path of a scenario file.
        parameters: Values of its parameters by name.
        share: Weight of the scenario. Its share of the worlds is its weight divided by the sum of all weights.
    """

    scenario: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    share: float = 1.0

    @property
    def label(self) -> str:
        """Name of the scenario with its share and its parameters, for the name of a folder."""
        share = [] if self.share == 1.0 else [f"{SHARE}={self.share:g}"]
        return "-".join(
            [Path(self.scenario).stem, *share, *(f"{key}={value}" for key, value in self.parameters.items())]
        )

    def to_plain(self) -> dict[str, Any]:
        """Return the part as plain data."""
        return {"scenario": self.scenario, "parameters": dict(self.parameters), "share": self.share}


def read_part(text: str) -> MixturePart:
    """Return the part that a text of the form ``SCENARIO[:share=WEIGHT][:PARAMETER=VALUE]...`` describes.

    Raises:
        IrsimGymError: If the text has another form.
    """
    scenario, *options = text.split(":")
    while options and "=" not in options[0]:  # a path with a colon
        scenario = f"{scenario}:{options.pop(0)}"
    given: dict[str, str] = {}
    for option in options:
        name, equals, value = option.partition("=")
        if not equals or not name or name in given:
            raise IrsimGymError(f"'{text}': write SCENARIO:NAME=VALUE:..., each name once, got '{option}'")
        given[name] = value
    return MixturePart(scenario, given, _weight(text, given.pop(SHARE, "1")))


def _weight(text: str, value: str) -> float:
    try:
        weight = float(value)
    except ValueError:
        weight = 0.0
    if not 0.0 < weight < float("inf"):
        raise IrsimGymError(f"'{text}': share must be a number > 0, the weight of the scenario, got '{value}'")
    return weight


def shared_worlds(shares: Sequence[float], n_worlds: int) -> list[int]:
    """Return the number of worlds of each scenario. Each gets its share of all worlds, and at least one.

    Args:
        shares: Weights of the scenarios.
        n_worlds: Number of all worlds.

    Raises:
        IrsimGymError: If there are fewer worlds than scenarios.
    """
    if n_worlds < len(shares):
        raise IrsimGymError(f"a mixture of {len(shares)} scenarios needs at least as many worlds: n_envs is {n_worlds}")
    wanted = [share / sum(shares) * n_worlds for share in shares]
    counts = [max(1, int(one)) for one in wanted]
    while sum(counts) != n_worlds:
        step = 1 if sum(counts) < n_worlds else -1
        open_ones = [k for k in range(len(counts)) if step > 0 or counts[k] > 1]
        counts[max(open_ones, key=lambda k: step * (wanted[k] - counts[k]))] += step
    return counts
