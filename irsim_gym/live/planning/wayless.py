"""Warnings of bodies that stand because their planner finds no way."""

from irsim_gym.base.errors import warn_caller
from irsim_gym.simulator.engine import Simulation


class WaylessBodies:
    """Warns once of each body whose behaviour has found no way to its goal."""

    def __init__(self) -> None:
        self._told = set[str]()

    def warn(self, simulation: Simulation) -> None:
        """Warn of the bodies without a way that no earlier step has told of."""
        goals, names = simulation.state.goal[0, :, :2], simulation.parts.names
        for group in simulation.parts.behaviors:
            if not hasattr(group.kind, "wayless"):
                continue
            for body in group.members[group.kind.wayless(group)[0]].tolist():
                if names[body] not in self._told:
                    self._told.add(names[body])
                    x, y = goals[body].tolist()
                    warn_caller(f"'{names[body]}' stands: its behavior finds no way to ({x:.4g}, {y:.4g})")
