"""The bodies of a world, also under the names that IR-SIM has for what they tell."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NoReturn

from irsim_gym.arraytypes import Floats
from irsim_gym.engine import Simulation
from irsim_gym.errors import UnknownNameError
from irsim_gym.live import hints
from irsim_gym.live.actions import Reference
from irsim_gym.live.body import Body
from irsim_gym.live.goals import Goals
from irsim_gym.live.painted import PaintedBeams
from irsim_gym.live.reports import ObstacleInfo, RobotInfo
from irsim_gym.live.roster import Roster
from irsim_gym.live.track import Track
from irsim_gym.world.model import OBSTACLE, ROBOT


class Crowd(ABC):
    """The bodies that are in a world now.

    Attributes:
        simulation: The simulator; another one after ``World.add``, ``remove`` and ``reload``.
        roster: Names and numbers of the bodies.
        goals: Writes goals; ``Body.set_goal`` uses it.
        track: Where bodies have been since the reset; ``Body.trajectory`` reads it.
        columns: Arrays are given away as IR-SIM's columns, shape ``(n, 1)``, and points as ``(2, n)``.
    """

    simulation: Simulation
    roster: Roster
    goals: Goals
    track: Track
    columns: bool

    @property
    @abstractmethod
    def painted(self) -> PaintedBeams:
        """Beams in colours of their own; ``Body.set_laser_color`` paints them."""

    if not TYPE_CHECKING:  # a checker of types would otherwise take any name for known

        def __getattr__(self, name: str) -> NoReturn:
            if name in dir(type(self)) or (name.startswith("_") and name not in hints.WORLD):
                object.__getattribute__(self, name)  # tells what went wrong in a property
            raise AttributeError(hints.missing("a world", name, hints.WORLD, dir(self)), name=name, obj=self)

    def __getitem__(self, reference: Reference) -> Body:
        """Return the body with some number or name.

        Raises:
            UnknownNameError: There is none.
        """
        return Body(self, self.roster.name(reference))

    def __iter__(self) -> Iterator[Body]:
        return iter(self.objects)

    def __len__(self) -> int:
        return len(self.names)

    @property
    def names(self) -> list[str]:
        """The names of all bodies that this level has, in the order in which they are stepped."""
        return self.roster.present()

    @property
    def objects(self) -> list[Body]:
        """All bodies."""
        return [Body(self, name) for name in self.names]

    @property
    def robots(self) -> list[Body]:
        """The robots."""
        return [Body(self, name) for name in self.roster.present(ROBOT)]

    @property
    def obstacles(self) -> list[Body]:
        """The obstacles."""
        return [Body(self, name) for name in self.roster.present(OBSTACLE)]

    @property
    def robot(self) -> Body:
        """The first robot.

        Raises:
            UnknownNameError: There is none.
        """
        if not (robots := self.robots):
            raise UnknownNameError(f"no robot in '{self.simulation.scenario.name}'")
        return robots[0]

    @property
    def robot_list(self) -> list[Body]:
        """IR-SIM's name for ``robots``."""
        return self.robots

    @property
    def obstacle_list(self) -> list[Body]:
        """IR-SIM's name for ``obstacles``."""
        return self.obstacles

    @property
    def robot_number(self) -> int:
        """How many robots there are."""
        return len(self.robots)

    @property
    def obstacle_number(self) -> int:
        """How many obstacles there are."""
        return len(self.obstacles)

    @property
    def static_objects(self) -> list[Body]:
        """The bodies that never move."""
        return [body for body in self.objects if body.static]

    @property
    def dynamic_objects(self) -> list[Body]:
        """The bodies that can move."""
        return [body for body in self.objects if not body.static]

    def get_object_by_name(self, name: str) -> Body | None:
        """Return the body of that name, None if there is none; ``world[name]`` raises then."""
        return next((body for body in self.objects if body.name == name), None)

    def get_object_by_id(self, target_id: int) -> Body | None:
        """Return the body with that number, None if there is none; ``world[number]`` raises then."""
        return next((body for body in self.objects if body.id == target_id), None)

    def get_group_by_name(self, group_name: str) -> list[Body]:
        """Return the bodies of a group; an entry's bodies are one, named after role and number unless it says else."""
        return [body for body in self.objects if body.group_name == group_name]

    def get_robot_state(self) -> Floats:
        """Return the state of the first robot."""
        return self.robot.state

    def get_robot_info(self, id: int = 0) -> RobotInfo:
        """Return what a robot is; it is meant by its number."""
        return self[id].info

    def get_robot_info_list(self) -> list[RobotInfo]:
        """Return what each robot is."""
        return [robot.info for robot in self.robots]

    def get_obstacle_info_list(self) -> list[ObstacleInfo]:
        """Return where each obstacle is."""
        return [obstacle.obstacle_info for obstacle in self.obstacles]

    def get_lidar_scan(self, id: int = 0) -> dict[str, Any]:
        """Return the scan of a body's first range sensor; see ``Body.scan``."""
        return self[id].scan()

    def get_lidar_offset(self, id: int = 0) -> tuple[float, float, float] | None:
        """Return the mount pose of a body's first sensor in the body frame [m, m, rad]."""
        return self[id].lidar_offset
