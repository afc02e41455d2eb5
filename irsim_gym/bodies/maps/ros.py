"""ros: a map of ROS, as its map servers save and read it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar, Literal

from irsim_gym.bodies.maps.level import CellsKind
from irsim_gym.scenario.reading.ros_map import read_ros_map
from irsim_gym.simulator.world.names import Flags, kind, option


@kind
class RosMap(CellsKind):
    """A map of ROS, `map.yaml` with its image; `width`, `height` and `offset` of the world follow from it."""

    is_random: ClassVar[bool] = False

    path: str = option(min_length=1, meaning="YAML file, as given or beside the scenario. It names the image.")
    unknown: Literal["free", "occupied"] = option("free", meaning="What cells are of which the map knows nothing.")

    def extent(self, find: Callable[[str], Path]) -> dict[str, Any]:
        """Return ``width``, ``height`` and ``offset`` of the world [m].

        Raises:
            OptionError: If the file or its image cannot be used.
        """
        return read_ros_map(find(self.path)).extent

    def occupied(self, width: float, height: float, name: str, find: Callable[[str], Path]) -> Flags:
        """Return which cells are occupied, shape ``(columns, rows)``.

        Raises:
            OptionError: If the file or its image cannot be used.
        """
        return read_ros_map(find(self.path)).occupied(self.unknown == "occupied")
