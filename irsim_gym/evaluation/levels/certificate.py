"""Certificates: the hash of each level of a set, what it demands of a robot, and results of reference policies."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Flags, Floats, Ints, Words
from irsim_gym.base.outside_files import reading
from irsim_gym.evaluation.levels import certificate_file
from irsim_gym.evaluation.levels.certificate_file import NUMBERS, WHOLE, Numbers
from irsim_gym.evaluation.measures.metrics import OUTCOMES
from irsim_gym.scenario.specs import library
from irsim_gym.scenario.specs.level_set import set_hash
from irsim_gym.scenario.specs.spec import Scenario

SUFFIX = ".certificate.npz"
FOLDER = "certificates"
QUARTERS = 4


@dataclass(frozen=True)
class Certificate:
    """Measures of the levels 0, 1, ... of one split of a scenario.

    Attributes:
        name: Name of the scenario, with the values of its parameters.
        scenario_hash: Hash of the parts of the scenario that define its levels.
        split: Name of the split.
        agents: Names of the robots that were measured, and that the policies drove.
        policies: Names of the reference policies.
        hash: Hash of everything drawn, shape ``(n_levels,)``.
        reachable: Whether a path leads from the start through all goals, shape ``(n_levels, n_agents)``.
        length: Length of the shortest path found [m], likewise; infinite without one.
        straight: Length of the straight lines through all goals [m], likewise.
        clearance: Clearance along the widest path [m], likewise; NaN without a path.
        least_time: Lower bound of the time for the limits of speed and acceleration [s], likewise.
        density: Share of the world that standing bodies and the map cover, shape ``(n_levels,)``.
        outcome: Outcome of each policy, an index of ``OUTCOMES``, shape ``(n_policies, n_levels, n_agents)``.
        time: Duration of its episode [s], likewise; NaN if it fails. Files of format 1 have it there, too.
        versions: Versions of the packages that made the certificate.
    """

    name: str
    scenario_hash: str
    split: str
    agents: tuple[str, ...]
    policies: tuple[str, ...]
    hash: Words
    reachable: Flags
    length: Numbers
    straight: Numbers
    clearance: Numbers
    least_time: Numbers
    density: Numbers
    outcome: NDArray[np.uint8]
    time: Numbers
    versions: Mapping[str, str] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of levels."""
        return len(self.hash)

    @property
    def set_hash(self) -> str:
        """Hash of all levels together."""
        return set_hash(self.hash)

    @property
    def tortuosity(self) -> Floats:
        """Length of the shortest path divided by the straight length, at least 1, shape ``(n_levels, n_agents)``."""
        tortuosity = np.ones(self.length.shape)
        np.divide(self.length, self.straight, out=tortuosity, where=self.straight > 0.0)
        return np.maximum(tortuosity, 1.0)

    @property
    def difficulty(self) -> Floats:
        """Share of the reference policies' episodes that fail, shape ``(n_levels,)``."""
        failed: Floats = (self.outcome != OUTCOMES.index("success")).mean(axis=(0, 2))
        return failed if len(self.policies) else np.zeros(self.count)

    @property
    def solved(self) -> Flags:
        """Whether a reference policy brings all agents to their goals, shape ``(n_levels,)``."""
        arrived: Flags = (self.outcome == OUTCOMES.index("success")).all(axis=2).any(axis=0)
        return arrived

    def ranked(self, count: int) -> Ints:
        """Return the first ``count`` levels from the easiest to the hardest, shape ``(count,)``."""
        return np.lexsort((self.least_time.max(axis=1)[:count], self.difficulty[:count])).astype(np.int64)

    def quarters(self, count: int | None = None) -> Ints:
        """Return the quarter of difficulty of each of the first levels, from 0 (easiest) to 3, shape ``(count,)``.

        Among levels of equal difficulty, those with a longer least time count as harder.
        """
        ranked = self.ranked(self.count if count is None else count)
        quarter = np.zeros(len(ranked), np.int64)
        quarter[ranked] = np.arange(len(ranked)) * QUARTERS // len(ranked)
        return quarter

    def matches(self, digest: str, count: int) -> bool:
        """Return whether the set of the first ``count`` levels has the hash ``digest``."""
        return count <= self.count and set_hash(self.hash[:count]) == digest

    def content(self) -> bytes:
        """Return the content of the certificate's file; equal certificates give equal bytes."""
        said = {name: getattr(self, name) for name in ("name", "scenario_hash", "split", "agents", "policies")}
        said |= {"versions": dict(self.versions), "set_hash": self.set_hash, "levels": self.count}
        return certificate_file.certificate_bytes(said, {name: getattr(self, name) for name in (*WHOLE, *NUMBERS)})


def read_certificate(file: Path) -> Certificate:
    """Read a certificate.

    Raises:
        UnreadableFileError: If the file is not a certificate.
    """
    with reading(file, "certificate of levels"):
        said, arrays = certificate_file.read_certificate_file(file)
        said |= {name: tuple(map(str, said[name])) for name in ("agents", "policies")}
        fields = {key: value for key, value in said.items() if key not in ("format", "set_hash", "levels")}
        cert = Certificate(**fields, **arrays)
        _check(cert)
    return cert


def _check(cert: Certificate) -> None:
    """Check the shapes and values of a certificate's arrays.

    Raises:
        ValueError: They do not fit each other.
    """
    if cert.hash.dtype != np.uint64 or cert.hash.ndim != 1:
        raise ValueError(f"hash must hold unsigned numbers of 64 bits, one a level, got {cert.hash.dtype}")
    each = (cert.count, len(cert.agents))
    shapes = {"density": each[:1], "outcome": (len(cert.policies), *each), "time": (len(cert.policies), *each)}
    for name in (*WHOLE[1:], *NUMBERS):
        array, shape = getattr(cert, name), shapes.get(name, each)
        if array.shape != shape or array.dtype.kind not in "bufi":
            raise ValueError(f"{name} must hold numbers of shape {shape}, got {array.dtype}, shape {array.shape}")
    if cert.outcome.size and not 0 <= cert.outcome.min() <= cert.outcome.max() < len(OUTCOMES):
        raise ValueError(f"outcome must be 0 to {len(OUTCOMES) - 1}, got {cert.outcome.min()} to {cert.outcome.max()}")


def find_certificate(
    scenario: Scenario, agents: Sequence[str], split: str, digest: str, count: int
) -> Certificate | None:
    """Return the certificate of a scenario's levels.

    It is looked up next to the file of levels, next to the scenario's own file, and among the shipped ones.

    Args:
        agents: Names of the robots that are driven.
        digest: Hash of the set of levels.
        count: Number of levels, from level 0.

    Returns:
        The certificate; None if there is none for these agents and levels.
    """
    files = [scenario.levels.file] if scenario.levels is not None else []
    beside = [certificate_beside(Path(file)) for file in (*files, scenario.file) if file]
    for file in (*beside, shipped_certificate(scenario)):
        if file.is_file():
            cert = read_certificate(file)
            if cert.split == split and cert.agents == tuple(agents) and cert.matches(digest, count):
                return cert
    return None


def certificate_beside(file: Path) -> Path:
    """Return the path of the certificate of a file of levels, or of a scenario's own file; it need not exist."""
    return file.with_name(file.stem + SUFFIX)


def shipped_certificate(scenario: Scenario) -> Path:
    """Return the path of a shipped scenario's certificate, named by changed parameters; it need not exist."""
    stem = Path(scenario.file).stem if scenario.file else scenario.name
    declared = scenario.source.data.get("parameters") or {}
    values = scenario.parameters.items()
    changed = [f"-{name}={value}" for name, value in values if name in declared and value != declared[name]["default"]]
    return library.configs_folder() / FOLDER / f"{stem}{''.join(changed)}.npz"
