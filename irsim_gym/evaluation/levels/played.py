"""The levels of an evaluation: their identity, and success by difficulty."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from rich.table import Table

from irsim_gym.base.arraytypes import Ints
from irsim_gym.evaluation.levels.certificate import QUARTERS, Certificate, find_certificate
from irsim_gym.evaluation.levels.draw import draw_levels
from irsim_gym.evaluation.measures.metrics import wilson
from irsim_gym.evaluation.protocol.tables import NARROW, figure_table
from irsim_gym.scenario.specs.level_set import set_hash
from irsim_gym.simulator.engine import Simulation

QUARTER_NAMES = ("easiest quarter", "second", "third", "hardest quarter")


@dataclass(frozen=True)
class PlayedLevels:
    """Levels 0, 1, ... of a split, as an evaluation plays them.

    Attributes:
        count: Number of levels.
        hash: Hash of everything that was drawn for them.
        file: Their file; empty if they are drawn.
        certificate: Their certificate; None without one.
    """

    count: int
    hash: str
    file: str
    certificate: Certificate | None

    def __str__(self) -> str:
        source = f" of {self.file}" if self.file else ""
        return f"set {self.hash}{source}{', certified' if self.certificate is not None else ''}"

    @property
    def unsolved(self) -> int | None:
        """Number of levels that no reference policy solves; None without a certificate, or without such policies."""
        if self.certificate is None or not self.certificate.policies:
            return None
        return int((~self.certificate.solved[: self.count]).sum())

    @property
    def quarters(self) -> Ints | None:
        """Quarter of difficulty of each level, 0 to 3, shape ``(count,)``; None if it is not known.

        It is not known without a certificate, for a certificate without policies, or for fewer than four levels.
        """
        if self.certificate is None or self.count < QUARTERS or not self.certificate.policies:
            return None
        return self.certificate.quarters(self.count)

    def conditions(self) -> dict[str, object]:
        """Return the conditions to name with published figures."""
        certificate = self.certificate
        return {
            "level_hash": self.hash,
            "level_file": self.file or None,
            "certificate": None if certificate is None else certificate.name,
            "certified_by": None if certificate is None else list(certificate.policies),
            "unsolved": self.unsolved,
        }

    def tables(self, solved: Mapping[str, Sequence[bool]]) -> list[Table]:
        """Return the table of success by difficulty; empty if the quarters of difficulty are not known.

        Args:
            solved: Success in each level, by policy.
        """
        quarters = self.quarters
        if self.certificate is None or quarters is None:
            return []
        policies = ", ".join(self.certificate.policies)
        title = (
            f"success [%] by difficulty: levels in the order of how many of {policies} fail; "
            f"{self.unsolved:,} of {self.count:,} are solved by none"
        )
        rows = []
        for policy, successes in solved.items():
            shares = (np.array(successes)[quarters == k] for k in range(QUARTERS))
            rows.append((policy, *(_share(int(chosen.sum()), len(chosen)) for chosen in shares)))
        return [figure_table(title, ("policy", *QUARTER_NAMES), rows, **NARROW)]


def _share(count: int, total: int) -> str:
    low, high = wilson(count, total)
    return f"{100.0 * count / total:.1f} ({100.0 * low:.1f}-{100.0 * high:.1f})"


def played_levels(simulation: Simulation, split: str, count: int) -> PlayedLevels:
    """Return the first ``count`` levels of a split, after drawing them to compute their hash."""
    digest = set_hash(draw_levels(simulation, [split], count).hashes())
    levels, agents = simulation.scenario.levels, [simulation.parts.names[b] for b in simulation.agents]
    certificate = find_certificate(simulation.scenario, agents, split, digest, count)
    return PlayedLevels(count, digest, "" if levels is None else levels.file, certificate)
