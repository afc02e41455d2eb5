"""IR-SIM's factory of outlines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn, final

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.irsim.rotations import geometry_transform
from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.readings.shapely_outline import shapely_outline
from irsim_gym.simulator.world.outline import corner_points, extent


@final
class ShapeOutline:
    """A shape as in a file, as shapely geometry.

    Args:
        name: Name of the shape.
        footprint: The shape.

    Attributes:
        name: Name of the shape.
        original_geometry: The outline in its own frame.
        geometry: The outline where ``step`` has placed it.
        length: Size along its own x axis [m].
        width: Size along its own y axis [m].
        original_vertices: Corners in its own frame [m], shape ``(2, n)``.

    Raises:
        ValueError: The shape is random.
    """

    def __init__(self, name: str, footprint: Any) -> None:
        if footprint.is_random:
            raise ValueError("a random shape is drawn with a level: take the geometry of a body")
        outline = footprint.outline()
        self.name, self.wheelbase = name, getattr(footprint, "wheelbase", None)
        self.geometry = shapely_outline(outline.segments, outline.discs, solid=outline.solid)
        self.original_geometry = self.geometry
        self.length, self.width = extent(outline.segments, outline.discs)
        self.original_vertices = corner_points(outline.segments, outline.discs, 0.0, rounds=True).T

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> NoReturn:
            message = f"an outline has no '{name}': use geometry, original_vertices, or a body's vertices, get_Gh()"
            raise AttributeError(message, name=name, obj=self)

    @property
    def radius(self) -> float:
        """Radius of the least circle around it [m]."""
        import shapely

        return float(shapely.minimum_bounding_radius(self.original_geometry))

    def step(self, state: ArrayLike) -> Any:
        """Place it at a state ``[x, y, heading]`` [m, m, rad], flat or a column, and return ``geometry``."""
        self.geometry = geometry_transform(self.original_geometry, np.asarray(state, np.float64))
        return self.geometry


@final
class GeometryFactory:
    """Makes outlines of the shapes of files."""

    @staticmethod
    def create_geometry(name: str = "circle", **options: Any) -> ShapeOutline:
        """Return the outline of a shape.

        Args:
            name: Its name, as in ``shape: {name: circle}``.
            **options: Its options, as there.

        Raises:
            ScenarioError: There is no such shape, or an option is not valid.
            ValueError: The shape is random.
        """
        bodies = load_scenario({"obstacle": {"shape": {"name": name, **options}}}).bodies
        return ShapeOutline(name, bodies[0].shape)
