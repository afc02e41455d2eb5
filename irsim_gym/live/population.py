"""Bodies that come and go while a world runs, and obstacles that are put somewhere else."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Sequence
from typing import Any, Literal

import numpy as np

from irsim_gym.engine import Simulation
from irsim_gym.live import moves, reports
from irsim_gym.live.actions import Reference
from irsim_gym.live.body import Body
from irsim_gym.live.camera import Camera
from irsim_gym.live.carry import rebuild
from irsim_gym.live.standing import Standing
from irsim_gym.scenario.edit import add_bodies, remove_body
from irsim_gym.world.model import OBSTACLE


class Population(Standing):
    """The bodies of a world, and what changes who is there."""

    _camera: Camera

    @abstractmethod
    def refresh(self) -> None:
        """Bring outlines, flags, scans and status up to date."""

    def add(self, role: Literal["robot", "obstacle"] = "obstacle", **entry: Any) -> Body:
        """Add a body; everything else stays as it is, and a reset keeps it.

        Args:
            role: Which section the entry would stand in.
            **entry: The keys of an entry, e.g. ``shape={"name": "circle"}, state=[1, 2, 0]``.

        Raises:
            ScenarioError: The entry cannot be used; the error names the key, as for a file.
            PlacementError: A random start found no place among the bodies that are here.
            ValueError: It would make several bodies.
        """
        if entry.get("number", 1) != 1 or entry.get("number_range") is not None:
            raise ValueError("one body at a time: leave number and number_range out")
        before = set(self.simulation.parts.names)
        self._follow(
            rebuild(self.simulation, add_bodies(self.simulation.scenario, role, entry, self.roster.next_number))
        )
        return Body(self, next(name for name in self.simulation.parts.names if name not in before))

    def remove(self, reference: Reference) -> None:
        """Remove the body with some number or name; the others keep their numbers.

        Raises:
            UnknownNameError: There is none.
        """
        self._follow(rebuild(self.simulation, remove_body(self.simulation.scenario, self.roster.index(reference))))

    def _follow(self, simulation: Simulation) -> None:
        self.simulation = simulation
        self.roster.follow(simulation)
        self.goals.follow(simulation)
        self.track.follow(simulation)
        self._camera.look_at(simulation)

    def create_robot(self, **entry: Any) -> Body:
        """Add a robot; it is in the world at once, so IR-SIM's ``add_object`` has nothing left to do."""
        return self.add("robot", **entry)

    def create_obstacle(self, **entry: Any) -> Body:
        """Add an obstacle; it is in the world at once, so IR-SIM's ``add_object`` has nothing left to do."""
        return self.add("obstacle", **entry)

    def add_object(self, body: Body) -> None:
        """Do nothing: what ``create_robot`` and ``create_obstacle`` return is in the world already.

        Raises:
            TypeError: It is no body of this world.
        """
        if body not in self.objects:
            raise TypeError(f"only what create_robot() or create_obstacle() of this world returned, got {body!r}")

    def add_objects(self, bodies: Iterable[Body]) -> None:
        """Do nothing, as ``add_object``."""
        for body in bodies:
            self.add_object(body)

    def delete_object(self, target_id: Reference) -> None:
        """Remove the body with some number or name."""
        self.remove(target_id)

    def delete_objects(self, target_ids: Iterable[Reference]) -> None:
        """Remove the bodies with some numbers or names; if one of them does not exist, none is removed."""
        for name in {self.roster.name(number) for number in target_ids}:
            self.remove(name)

    def random_obstacle_position(
        self,
        range_low: Sequence[float] = (0.0, 0.0, -np.pi),
        range_high: Sequence[float] = (10.0, 10.0, np.pi),
        ids: Sequence[Reference] | None = None,
        non_overlapping: bool = False,
    ) -> None:
        """Put obstacles somewhere at random, for now and for later resets without ``random``.

        Args:
            range_low: Least x, y, heading [m, m, rad].
            range_high: Greatest.
            ids: Numbers or names of bodies; by default all obstacles but the map.
            non_overlapping: Clear of all other bodies.

        Raises:
            PlacementError: One of them found no place clear of the others; then none has moved.
            ValueError: One of them is the obstacle map.
        """
        obstacles = self.roster.present(OBSTACLE) if ids is None else ids
        bodies = [self.roster.index(reference) for reference in obstacles]
        if ids is None:
            bodies = [b for b in bodies if not reports.is_map(self.simulation, b)]
        for b in bodies:
            reports.refuse_map(self.simulation, b)
        moves.scatter(self.simulation, bodies, range_low, range_high, apart=non_overlapping)
        self.refresh()
