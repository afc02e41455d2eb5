"""The bodies of a world that a script steps: finding, adding, removing and moving them."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, Literal

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.errors import UnknownNameError
from irsim_gym.live.population import body_info
from irsim_gym.live.population.body import Body
from irsim_gym.live.population.body_info import ObstacleInfo, RobotInfo
from irsim_gym.live.population.carry import rebuild
from irsim_gym.live.session import moves
from irsim_gym.live.session.roster import Reference
from irsim_gym.live.session.run_status import RunStatus
from irsim_gym.live.session.session import Session
from irsim_gym.scenario.reading.edit import add_bodies, remove_body
from irsim_gym.simulator.readings.contact_readings import ContactRecord
from irsim_gym.simulator.world.model import OBSTACLE, ROBOT


class Population:
    """The bodies of a session.

    Args:
        session: The session.
        status: The status, which is updated when bodies are moved.
    """

    def __init__(self, session: Session, status: RunStatus) -> None:
        self._session, self._status = session, status

    def __getitem__(self, reference: Reference) -> Body:
        """Return the body with this number or name.

        Raises:
            UnknownNameError: There is no such body.
        """
        return Body(self._session, self._session.roster.name(reference))

    def __iter__(self) -> Iterator[Body]:
        return iter(self.objects)

    def __len__(self) -> int:
        return len(self.names)

    @property
    def names(self) -> list[str]:
        """The names of all bodies of this level, in the order of stepping."""
        return self._session.roster.present()

    @property
    def objects(self) -> list[Body]:
        """All bodies."""
        return [Body(self._session, name) for name in self.names]

    @property
    def robots(self) -> list[Body]:
        """The robots."""
        return [Body(self._session, name) for name in self._session.roster.present(ROBOT)]

    @property
    def obstacles(self) -> list[Body]:
        """The obstacles."""
        return [Body(self._session, name) for name in self._session.roster.present(OBSTACLE)]

    @property
    def robot(self) -> Body:
        """The first robot.

        Raises:
            UnknownNameError: There is no robot.
        """
        if not (robots := self.robots):
            raise UnknownNameError(f"no robot in '{self._session.simulation.scenario.name}'")
        return robots[0]

    @property
    def robot_number(self) -> int:
        """Number of robots."""
        return len(self.robots)

    @property
    def obstacle_number(self) -> int:
        """Number of obstacles."""
        return len(self.obstacles)

    @property
    def static_objects(self) -> list[Body]:
        """The bodies that never move."""
        return [body for body in self.objects if body.static]

    @property
    def dynamic_objects(self) -> list[Body]:
        """The bodies that can move."""
        return [body for body in self.objects if not body.static]

    @property
    def contacts(self) -> list[ContactRecord]:
        """The contacts of the last step; none unless the world's ``collision_mode`` is ``contact``."""
        return self.objects[0]._records() if len(self) else []

    def get_object_by_name(self, name: str) -> Body | None:
        """Return the body with this name, or None; ``world[name]`` raises an error instead."""
        return next((body for body in self.objects if body.name == name), None)

    def get_object_by_id(self, target_id: int) -> Body | None:
        """Return the body with this number, or None; ``world[number]`` raises an error instead."""
        return next((body for body in self.objects if body.id == target_id), None)

    def get_group_by_name(self, group_name: str) -> list[Body]:
        """Return the bodies of a group. Each entry is one, named after role and number unless the entry names it."""
        return [body for body in self.objects if body.group_name == group_name]

    def get_robot_state(self) -> Floats:
        """Return the state of the first robot."""
        return self.robot.state

    def get_robot_info(self, id: int | str = 0) -> RobotInfo:
        """Return the properties of the robot at this position in ``robots``, or of the body with this name."""
        return self._robot(id).info

    def get_robot_info_list(self) -> list[RobotInfo]:
        """Return the properties of each robot."""
        return [robot.info for robot in self.robots]

    def get_obstacle_info_list(self) -> list[ObstacleInfo]:
        """Return the place and motion of each obstacle."""
        return [obstacle.obstacle_info for obstacle in self.obstacles]

    def get_lidar_scan(self, id: int | str = 0) -> dict[str, Any]:
        """Return the scan of a robot's first range sensor; ``id`` as for ``get_robot_info``. See ``Body.scan``."""
        return self._robot(id).scan()

    def get_lidar_offset(self, id: int | str = 0) -> tuple[float, float, float] | None:
        """Return where a robot's first sensor is in its frame [m, m, rad]; ``id`` as for ``get_robot_info``."""
        return self._robot(id).lidar_offset

    def _robot(self, position: int | str) -> Body:
        """Return the robot at a position in ``robots``, as IR-SIM counts them, or the body with a name.

        Raises:
            UnknownNameError: There is none.
        """
        if isinstance(position, str):
            return self[position]
        robots = self.robots
        if not -len(robots) <= position < len(robots):
            known = ", ".join(f"{k} '{robot.name}'" for k, robot in enumerate(robots)) or "none"
            raise UnknownNameError(f"no robot number {position}; robots in the order of robot_list: {known}")
        return robots[position]

    def add(self, /, role: Literal["robot", "obstacle"] = "obstacle", **entry: object) -> Body:
        """Add a body. Nothing else changes, and a reset keeps the body.

        Args:
            role: The section of the entry.
            **entry: The keys of an entry, e.g. ``shape={"name": "circle"}, state=[1, 2, 0]``.

        Raises:
            ScenarioError: The entry cannot be used; the error names the key, as for a file.
            PlacementError: There is no free place for a random start.
            ValueError: The entry describes several bodies.
        """
        if entry.get("number", 1) != 1 or entry.get("number_range") is not None:
            raise ValueError("one body at a time: leave number and number_range out")
        session = self._session
        before = session.simulation
        scenario = add_bodies(before.scenario, role, entry, session.roster.next_number)
        session.replace(rebuild(before, scenario))
        return Body(session, next(name for name in session.simulation.parts.names if name not in before.parts.names))

    def remove(self, reference: Reference) -> None:
        """Remove the body with this number or name; the others keep their numbers.

        Raises:
            UnknownNameError: There is no such body.
        """
        now = self._session.simulation
        self._session.replace(rebuild(now, remove_body(now.scenario, self._session.roster.index(reference))))

    def create_robot(self, /, **entry: object) -> Body:
        """Add a robot at once; IR-SIM's ``add_object`` is not needed."""
        return self.add("robot", **entry)

    def create_obstacle(self, /, **entry: object) -> Body:
        """Add an obstacle at once; IR-SIM's ``add_object`` is not needed."""
        return self.add("obstacle", **entry)

    def add_object(self, body: Body) -> None:
        """Do nothing, because ``create_robot`` and ``create_obstacle`` have added the body already.

        Raises:
            TypeError: ``body`` is not a body of this world.
        """
        if body not in self.objects:
            raise TypeError(f"only what create_robot() or create_obstacle() of this world returned, got {body!r}")

    def add_objects(self, bodies: Iterable[Body]) -> None:
        """Do nothing, like ``add_object``."""
        for body in bodies:
            self.add_object(body)

    def delete_object(self, target_id: Reference) -> None:
        """Remove the body with this number or name."""
        self.remove(target_id)

    def delete_objects(self, target_ids: Iterable[Reference]) -> None:
        """Remove the bodies with these numbers or names, or none if one of them does not exist."""
        for name in {self._session.roster.name(number) for number in target_ids}:
            self.remove(name)

    def random_obstacle_position(
        self,
        range_low: Sequence[float] = (0.0, 0.0, -np.pi),
        range_high: Sequence[float] = (10.0, 10.0, np.pi),
        ids: Sequence[Reference] | None = None,
        non_overlapping: bool = False,
    ) -> None:
        """Move obstacles to random places. A ``reset`` without ``random`` keeps these places.

        Args:
            range_low: Minimum x, y, heading [m, m, rad].
            range_high: Maximum x, y, heading [m, m, rad].
            ids: Numbers or names of obstacles (default: all except the map).
            non_overlapping: Whether the places must be clear of all other bodies.

        Raises:
            PlacementError: There is no clear place for one of them; none has moved.
            UnknownNameError: There is no such body.
            ValueError: One of them is the obstacle map, or a robot.
        """
        roster, simulation = self._session.roster, self._session.simulation
        bodies = [roster.index(reference) for reference in (roster.present(OBSTACLE) if ids is None else ids)]
        if ids is None:
            bodies = [b for b in bodies if not body_info.is_map(simulation, b)]
        for b in bodies:
            body_info.refuse_map(simulation, b)
            if simulation.model.role[b] != OBSTACLE:
                raise ValueError(f"'{simulation.parts.names[b]}' is no obstacle: set_state moves a robot")
        moves.scatter(simulation, bodies, range_low, range_high, apart=non_overlapping)
        self._status.refresh()

    def random_polygon_shape(self, /, *others: object, **named: object) -> None:
        """Do nothing where no obstacle is a polygon, as in IR-SIM.

        Args:
            *others: IR-SIM's bounds.
            **named: Likewise.

        Raises:
            ValueError: An obstacle is a polygon: outlines are drawn at the beginning of a level.
        """
        names = [body.name for body in self.obstacles if body.shape == "polygon"]
        if names:
            raise ValueError(
                f"the outline of '{names[0]}' stays in this level: shape: {{name: polygon, random_shape: true}} in the "
                "file draws it, and reset(random=True) draws it anew"
            )
