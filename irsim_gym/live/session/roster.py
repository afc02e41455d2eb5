"""Names and numbers of bodies, and their indices in the simulation's arrays."""

from irsim_gym.base.errors import UnknownNameError
from irsim_gym.scenario.text.messages import show
from irsim_gym.simulator.engine import Simulation

Reference = int | str
"""Number or name of a body."""


class Roster:
    """The bodies of a world. A body keeps its number while others are added or removed.

    Args:
        simulation: The world; at first a body's number is its index.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._index = {name: b for b, name in enumerate(simulation.parts.names)}
        self._numbers = dict(self._index)
        self.next_number = len(self._index)

    def __len__(self) -> int:
        return len(self._index)

    def follow(self, simulation: Simulation) -> None:
        """Update the roster to a changed simulation; new bodies get the next numbers."""
        self._simulation = simulation
        self._index = {name: b for b, name in enumerate(simulation.parts.names)}
        for name in self._index:
            if name not in self._numbers:
                self._numbers[name] = self.next_number
                self.next_number += 1
        self._numbers = {name: self._numbers[name] for name in self._index}

    def index(self, reference: Reference) -> int:
        """Return the index of the body with a number or name in the arrays.

        Raises:
            UnknownNameError: There is none; the message offers the nearest name.
        """
        return self._index[self.name(reference)]

    def name(self, reference: Reference) -> str:
        """Return the name of the body with some number or name.

        Raises:
            UnknownNameError: There is none; the message offers the nearest name.
        """
        if isinstance(reference, str):
            if reference not in self._index:
                self._simulation.body(reference)  # raises with the nearest name
            return reference
        for name, number in self._numbers.items():
            if number == reference and not isinstance(reference, bool):
                return name
        raise UnknownNameError(f"no body number {show(reference)} in '{self._simulation.scenario.name}'")

    def number(self, name: str) -> int:
        """Return the number of the body of that name."""
        return self._numbers[self.name(name)]

    def present(self, role: int | None = None) -> list[str]:
        """Return the names of the bodies that this level has, in the order in which they are stepped."""
        model = self._simulation.model
        return [name for name, b in self._index.items() if model.present[0, b] and role in (None, model.role[b])]
