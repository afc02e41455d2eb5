"""What may look on while levels are played."""

from typing import Protocol

from irsim_gym.base.arraytypes import Ints
from irsim_gym.tasks import Episodes


class Watcher(Protocol):
    """Observes an evaluation without changing it."""

    def began(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Handle that levels have begun in worlds; ``indices`` are their positions among the evaluated levels."""

    def stepped(self, episodes: Episodes, worlds: Ints) -> None:
        """Handle that worlds have taken a step."""
