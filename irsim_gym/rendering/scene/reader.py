"""Reads scenes from the arrays of a simulation, without changing them."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Flags
from irsim_gym.rendering.looks import theme
from irsim_gym.rendering.looks.styles import BodyStyle, body_style, field_of_view
from irsim_gym.rendering.scene.body_reader import BodyReader, labels
from irsim_gym.rendering.scene.scan_reader import ScanReader
from irsim_gym.rendering.scene.scene import DrawnBody, FieldView, FogView, GoalView, MapView, Scene
from irsim_gym.rendering.scene.track_reader import TrackReader
from irsim_gym.scenario.specs.plot_spec import trailing
from irsim_gym.simulator.readings.marks import NOTHING, Mark, Overlay
from irsim_gym.simulator.readings.trails import Trails
from irsim_gym.simulator.world.group import Group
from irsim_gym.simulator.world.model import ROBOT, STATE, Model
from irsim_gym.simulator.world.state import State

if TYPE_CHECKING:
    from irsim_gym.scenario.specs.spec import Scenario

PARTS, MOST_PARTS = 12, 4_000_000
"""Number of parts per side into which a cell is divided to show its disc, and maximum number of parts of a map."""


class DrawnSimulation(NamedTuple):
    """What is drawn of a simulation.

    Attributes:
        scenario: The scenario, for names, colours and plot options.
        model: Constants of the simulation.
        state: Its present state.
        sensors: Its sensor groups; those with ``ranges`` and ``angles`` are drawn.
        learners: Bodies whose goals and trajectories are drawn by default.
        explored: Cells of the world that robots have seen, shape ``(n_worlds, n_columns, n_rows)``; None for no fog.
        marks: Returns marks of the simulation itself over a world.
    """

    scenario: Scenario
    model: Model
    state: State
    sensors: Sequence[Group]
    learners: Collection[int]
    explored: Flags | None
    marks: Callable[[int], tuple[Mark, ...]]


class SceneReader:
    """Makes scenes of one simulation.

    Args:
        drawn: The simulation.
        trails: Past poses of the bodies ``trailing(scenario.bodies, learners)``; by default those at which scenes were
            read.
    """

    def __init__(self, drawn: DrawnSimulation, trails: Trails | None = None) -> None:
        scenario, model, state, sensors, learners, self._explored, self._marks = drawn
        self._model, self._state = model, state
        self._names = [body.name for body in scenario.bodies]
        self._styles = [body_style(body, learner=b in learners) for b, body in enumerate(scenario.bodies)]
        order = sorted(range(len(self._styles)), key=lambda body: self._styles[body].order)
        self._fixed_bodies = [body for body in order if not model.movable[body]]
        self._moving_bodies = [body for body in order if model.movable[body]]
        self._robots = np.array([body for body in order if model.role[body] == ROBOT], np.int64)
        self._shows_goal = np.array([style.show_goal for style in self._styles], np.bool_)
        self._title = scenario.name if scenario.world.plot.title is None else scenario.world.plot.title
        self._viewpoint = scenario.world.plot.viewpoint
        self._fields = {b: field_of_view(body) for b, body in enumerate(scenario.bodies) if self._styles[b].show_field}
        self._fog: tuple[int, FogView] | None = None
        self._overlays: dict[int, Overlay] = {}
        self._map: tuple[Flags, MapView] | None = None
        self._fixed: tuple[object, tuple[DrawnBody, ...]] = None, ()
        if trails is None:
            trails = Trails(np.array(trailing(scenario.bodies, learners), np.int64), len(state.pose))
        self.trails = trails
        self._bodies = BodyReader(scenario, model, state, self._styles)
        self._tracks = TrackReader(trails, self._bodies, self._styles)
        ranging = [group for group in sensors if {"ranges", "angles"} <= group.arrays.keys()]
        self._scans = [ScanReader(group, self._styles) for group in ranging]

    def read(self, world: int, status: str = "") -> Scene:
        """Return the present scene of a world, and record the poses of its bodies for trails."""
        model, state = self._model, self._state
        self.trails.record(np.array([world]), state.step[[world]], state.pose[[world]])
        present = model.present[world]
        fixed = self._fixed_views(world, present)
        moving = tuple(self._bodies.view(world, body) for body in self._moving_bodies if present[body])
        aims = np.flatnonzero(model.has_goal & present & self._shows_goal).tolist()
        goals = tuple(self._goal(world, body) for body in aims)
        return Scene(
            world=world,
            bounds=model.bounds.copy(),
            title=self._title,
            time=float(state.time[world]),
            status=status or self.status(world),
            fixed=fixed,
            moving=moving,
            struck=self._colliding_views(world, fixed + moving),
            goals=goals,
            scans=tuple(view for scans in self._scans for view in scans.read(world, state.pose[world], present)),
            trails=self._tracks.paths(world, present),
            ghosts=self._tracks.ghosts(world, present),
            fields=self._field_views(world, present),
            labels=labels(fixed + moving, goals),
            map=self.map_view(world),
            center=self.center(world),
            fog=self._fog_view(world),
            overlay=self.overlay(world),
        )

    def clear(self, world: int | None = None) -> None:
        """Clear the trails of one world, or of all worlds."""
        self.trails.clear(None if world is None else np.array([world]))

    def lay_over(self, world: int, overlay: Overlay) -> None:
        """Set the marks over a world for later scenes."""
        self._overlays[world] = overlay

    def overlay(self, world: int) -> Overlay:
        """Return the marks over a world: first those of the simulation."""
        overlay, marks = self._overlays.get(world, NOTHING), self._marks(world)
        return replace(overlay, marks=(*marks, *overlay.marks)) if marks else overlay

    def status(self, world: int) -> str:
        """Return IR-SIM's status: arrived if all robots have arrived, else collision if one collides, else running."""
        state = self._state
        robots = self._robots[self._model.present[world, self._robots]]
        if len(robots) and bool(state.arrived[world, robots].all()):
            return "arrived"
        return "collision" if bool(state.collided[world, robots].any()) else "running"

    def _fixed_views(self, world: int, present: Flags) -> tuple[DrawnBody, ...]:
        """Return views of the fixed bodies: for reads of the same world, the same tuple until an outline changes."""
        bodies = [body for body in self._fixed_bodies if present[body]]
        key = world, self._bodies.signature(world, bodies)
        if key != self._fixed[0]:
            self._fixed = key, tuple(self._bodies.view(world, body) for body in bodies)
        return self._fixed[1]

    def _colliding_views(self, world: int, views: tuple[DrawnBody, ...]) -> tuple[DrawnBody, ...]:
        state = self._state
        robots = self._robots[state.collided[world, self._robots]]
        bodies = {*robots.tolist(), *state.hit[world, robots].tolist()}
        return tuple(view for view in views if view.body in bodies) if bodies else ()

    def _goal(self, world: int, body: int) -> GoalView:
        model, state = self._model, self._state
        x, y, heading = state.goal[world, body].tolist()
        counts = model.arrive_mode[body] == STATE
        later = slice(int(state.waypoint[world, body]) + 1, int(model.waypoint_count[world, body]))
        limits, faces = model.goal_threshold, heading if counts else math.nan
        within = float(limits[world % len(limits), body])
        name, style, arrived = self._names[body], self._styles[body], bool(state.arrived[world, body])
        rest = model.waypoints[world, body, later, :2].copy()
        return GoalView(x=x, y=y, heading=faces, tolerance=within, later=rest, arrived=arrived, name=name, style=style)

    def _field_views(self, world: int, present: Flags) -> tuple[FieldView, ...]:
        views = []
        for body, field in self._fields.items():
            if field is not None and present[body]:
                x, y, heading = self._state.pose[world, body].tolist()
                views.append(FieldView(x, y, heading, *field, self._styles[body]))
        return tuple(views)

    def map_view(self, world: int) -> MapView | None:
        """Return the occupancy map: for reads of the same world, the same object until the map changes."""
        x, y, width, height, body = self._model.map_frame.item()
        if body < 0:
            return None
        if self._map is not None and self._model.rigid[0]:
            return self._map[1]
        squares, radius = self._model.map_squares, float(self._model.map_disc[0])
        occupied = squares[world % len(squares), 0] == 0
        if self._map is None or not np.array_equal(self._map[0], occupied):
            extent = (x, y, x + width * occupied.shape[0], y + height * occupied.shape[1])
            style = self._styles[int(body)] if body < len(self._styles) else BodyStyle(theme.MAP)
            shown = occupied if radius == 0.0 else discs_in(occupied, radius / width, radius / height)
            self._map = occupied, MapView(extent, shown, style.colour, style.alpha)
        return self._map[1]

    def _fog_view(self, world: int) -> FogView | None:
        """Return the fog over the world: for reads of the same world, the same object until the seen area changes."""
        if self._explored is None:
            return None
        explored = self._explored[world]
        if self._fog is None or self._fog[0] != world or bool((self._fog[1].covered == explored).any()):
            x_min, y_min, x_max, y_max = (float(value) for value in self._model.bounds)
            self._fog = world, FogView((x_min, y_min, x_max, y_max), ~explored, theme.FOG, 1.0)
        return self._fog[1]

    def center(self, world: int) -> tuple[float, float] | None:
        """Return the point in the middle of the picture; None to show the whole world."""
        if not isinstance(self._viewpoint, str):
            return self._viewpoint
        if self._viewpoint not in self._names:
            return None  # the body was removed by a script
        x, y, _ = self._state.pose[world, self._names.index(self._viewpoint)]
        return float(x), float(y)


def discs_in(occupied: Flags, radius_x: float, radius_y: float) -> Flags:
    """Return a finer map with discs in the middle of occupied cells; radii are in widths and heights of a cell."""
    # Each cell becomes parts x parts smaller ones, as many as the finer map may have.
    parts = max(min(PARTS, int(math.sqrt(MOST_PARTS / occupied.size))), 1)
    middles = (np.arange(parts) + 0.5) / parts - 0.5
    disc = (middles[:, None] / radius_x) ** 2 + (middles[None, :] / radius_y) ** 2 <= 1.0
    return np.asarray(np.kron(occupied, disc), np.bool_)
