"""Quality of service."""

from dataclasses import dataclass
from enum import Enum


class ReliabilityPolicy(Enum):
    """Whether messages are sent again."""

    RELIABLE = 1
    BEST_EFFORT = 2


@dataclass(frozen=True, kw_only=True)
class QoSProfile:
    """A profile."""

    depth: int
    reliability: ReliabilityPolicy = ReliabilityPolicy.RELIABLE
