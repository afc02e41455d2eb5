"""Reads a scene from the arrays of a simulation; it writes nothing."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np

from irsim_gym.arraytypes import Flags
from irsim_gym.render import theme
from irsim_gym.render.body_reader import BodyReader, labels
from irsim_gym.render.outlines import placed
from irsim_gym.render.scene import (
    BodyView,
    FieldView,
    FogView,
    GoalView,
    MapView,
    ScanView,
    Scene,
    TrailView,
)
from irsim_gym.render.styles import BodyStyle, body_style, field_of_view, scan_style
from irsim_gym.scenario.plot_spec import trailing
from irsim_gym.world.group import Group
from irsim_gym.world.model import ROBOT, WorldModel
from irsim_gym.world.state import WorldState
from irsim_gym.world.trails import Trails

if TYPE_CHECKING:
    from irsim_gym.scenario.spec import Scenario

HIT_MARGIN = 1e-3
REMEMBERED_WORLDS = 16


class SceneReader:
    """Makes scenes of one simulation.

    Args:
        scenario: What is simulated, for names and plot options.
        model: Its constants.
        state: Its present state.
        sensors: Its sensor groups; those with ``ranges`` and ``angles`` are drawn.
        learners: Bodies whose goals and trajectories are drawn unless the scenario says otherwise.
        trails: Where bodies have been, of ``trailing(scenario.bodies, learners)``; by default where scenes were read.
        explored: Which cells of the world somebody has seen, shape ``(n_worlds, n_columns, n_rows)``; None for no fog.
    """

    def __init__(
        self,
        scenario: Scenario,
        model: WorldModel,
        state: WorldState,
        sensors: Sequence[Group],
        learners: Collection[int] = (),
        trails: Trails | None = None,
        explored: Flags | None = None,
    ) -> None:
        self._model, self._state = model, state
        self._scans = [group for group in sensors if {"ranges", "angles"} <= group.arrays.keys()]
        self._names = [body.name for body in scenario.bodies]
        self._styles = [body_style(body, learner=b in learners) for b, body in enumerate(scenario.bodies)]
        order = sorted(range(len(self._styles)), key=lambda body: self._styles[body].order)
        self._fixed_bodies = [body for body in order if not model.movable[body]]
        self._moving_bodies = [body for body in order if model.movable[body]]
        self._robots = [body for body in order if model.role[body] == ROBOT]
        self._title = scenario.name if scenario.world.plot.title is None else scenario.world.plot.title
        self._viewpoint = scenario.world.plot.viewpoint
        self._reader = BodyReader(scenario, model, state, self._styles)
        self._fields = {b: field_of_view(body) for b, body in enumerate(scenario.bodies) if self._styles[b].show_field}
        self._explored, self._fogs = explored, dict[int, FogView]()
        self._map: MapView | None = None
        self._fixed: dict[int, tuple[bytes, tuple[BodyView, ...]]] = {}
        if trails is None:
            trails = Trails(np.array(trailing(scenario.bodies, learners), np.int64), len(state.pose))
        self.trails = trails

    def read(self, world: int, status: str = "") -> Scene:
        """Return what world number ``world`` looks like now, and note where its bodies are for their trails."""
        model, state = self._model, self._state
        self.trails.record(np.array([world]), state.step[[world]], state.pose[[world]])
        fixed = self._fixed_views(world)
        moving = tuple(self._reader.view(world, body) for body in self._moving_bodies if model.present[world, body])
        goals = self._goals(world)
        return Scene(
            world=world,
            bounds=model.bounds.copy(),
            title=self._title,
            time=float(state.time[world]),
            status=status or self._status(world),
            fixed=fixed,
            moving=moving,
            struck=self._struck(world, fixed + moving),
            goals=goals,
            scans=self._scan_views(world),
            trails=self._trail_views(world),
            ghosts=self._ghosts(world),
            fields=self._field_views(world),
            labels=labels(fixed + moving, goals),
            map=self._map_view(),
            center=self._center(world),
            fog=self._fog_view(world),
        )

    def clear(self, world: int | None = None) -> None:
        """Forget the trails of one world, or of all."""
        self.trails.clear(None if world is None else np.array([world]))

    def _status(self, world: int) -> str:
        """Return IR-SIM's status: arrived when all robots have, else collision when one collides, else running."""
        state = self._state
        robots = [body for body in self._robots if self._model.present[world, body]]
        if robots and bool(state.arrived[world, robots].all()):
            return "arrived"
        return "collision" if robots and bool(state.collided[world, robots].any()) else "running"

    def _fixed_views(self, world: int) -> tuple[BodyView, ...]:
        """Return the views of the fixed bodies, the same tuple until one of their outlines changes."""
        bodies = [body for body in self._fixed_bodies if self._model.present[world, body]]
        key = self._reader.signature(world, bodies)
        known = self._fixed.pop(world, None)
        if known is None or known[0] != key:
            known = key, tuple(self._reader.view(world, body) for body in bodies)
            if len(self._fixed) >= REMEMBERED_WORLDS:
                self._fixed.pop(next(iter(self._fixed)))
        self._fixed[world] = known
        return known[1]

    def _struck(self, world: int, views: tuple[BodyView, ...]) -> tuple[BodyView, ...]:
        state = self._state
        robots = [body for body in self._robots if state.collided[world, body]]
        bodies = {*robots, *(int(state.hit[world, body]) for body in robots)}
        return tuple(view for view in views if view.body in bodies)

    def _goals(self, world: int) -> tuple[GoalView, ...]:
        model, state = self._model, self._state
        shown = model.has_goal & model.present[world]
        views = []
        for body in (int(body) for body in np.flatnonzero(shown) if self._styles[int(body)].show_goal):
            x, y, heading = (float(value) for value in state.goal[world, body])
            later = slice(int(state.waypoint[world, body]) + 1, int(model.waypoint_count[world, body]))
            views.append(
                GoalView(
                    x=x,
                    y=y,
                    heading=heading,
                    tolerance=float(model.goal_threshold[world % len(model.goal_threshold), body]),
                    later=model.waypoints[world, body, later, :2].copy(),
                    arrived=bool(state.arrived[world, body]),
                    name=self._names[body],
                    style=self._styles[body],
                )
            )
        return tuple(views)

    def _scan_views(self, world: int) -> tuple[ScanView, ...]:
        model = self._model
        return tuple(
            self._scan_view(world, group, k)
            for group in self._scans
            for k, body in enumerate(group.members)
            if model.present[world, body] and self._styles[int(body)].show_sensor
        )

    def _scan_view(self, world: int, group: Group, k: int) -> ScanView:
        options, pose = group.options[k], self._state.pose[world, group.members[k]]
        mount = np.asarray(getattr(options, "offset", (0.0, 0.0, 0.0)), np.float64)
        origin = placed(mount[None, :2], pose)[0]
        heading = float(pose[2] + mount[2])
        angles = group.arrays["angles"] + heading
        ranges = group.arrays["ranges"][world, k].astype(np.float64)
        hits = ranges < options.range_max - HIT_MARGIN
        speeds = group.arrays.get("radial_velocity")
        span = float(group.arrays["angles"][-1] - group.arrays["angles"][0])
        return ScanView(
            origin=origin,
            ends=origin + ranges[:, None] * np.column_stack([np.cos(angles), np.sin(angles)]),
            hits=hits,
            valid=hits & (ranges > getattr(options, "range_min", 0.0)),
            speeds=np.zeros(len(ranges)) if speeds is None else speeds[world, k].copy(),
            surrounds=span > 2.0 * np.pi * (1.0 - 1.5 / max(len(angles), 2)),
            style=scan_style(options),
            body=int(group.members[k]),
            heading=heading,
            angles=group.arrays["angles"].astype(np.float64),
        )

    def _field_views(self, world: int) -> tuple[FieldView, ...]:
        views = []
        for body, field in self._fields.items():
            if field is not None and self._model.present[world, body]:
                x, y, heading = (float(value) for value in self._state.pose[world, body])
                views.append(FieldView(x, y, heading, *field, self._styles[body]))
        return tuple(views)

    def _map_view(self) -> MapView | None:
        """Return the occupancy map; it is the same in all worlds and at all times."""
        x, y, width, height, body = (float(value) for value in self._model.map_frame)
        if self._map is None and body >= 0:
            occupied = self._model.map_squares[0] == 0
            extent = (x, y, x + width * occupied.shape[0], y + height * occupied.shape[1])
            style = self._styles[int(body)] if body < len(self._styles) else BodyStyle(theme.MAP)
            self._map = MapView(extent, occupied, style.colour, style.alpha)
        return self._map

    def _fog_view(self, world: int) -> FogView | None:
        """Return the fog over the world, the same object until somebody sees more of it."""
        if self._explored is None:
            return None
        known, explored = self._fogs.pop(world, None), self._explored[world]
        if known is None or bool((known.covered == explored).any()):
            x_min, y_min, x_max, y_max = (float(value) for value in self._model.bounds)
            known = FogView((x_min, y_min, x_max, y_max), ~explored, theme.FOG, 1.0)
            if len(self._fogs) >= REMEMBERED_WORLDS:
                self._fogs.pop(next(iter(self._fogs)))
        self._fogs[world] = known
        return known

    def _center(self, world: int) -> tuple[float, float] | None:
        """Return the point that stays in the middle of the picture."""
        if not isinstance(self._viewpoint, str):
            return self._viewpoint
        if self._viewpoint not in self._names:
            return None  # it was taken out of the world by hand
        x, y, _ = self._state.pose[world, self._names.index(self._viewpoint)]
        return float(x), float(y)

    def _trail_views(self, world: int) -> tuple[TrailView, ...]:
        views = []
        for index, body in enumerate(self.trails.bodies):
            style = self._styles[int(body)]
            if style.show_trajectory and self._model.present[world, body]:
                poses = self.trails.poses(world, index, length=style.trajectory_length)
                views.append(TrailView(poses[:, :2], style))
        return tuple(views)

    def _ghosts(self, world: int) -> tuple[BodyView, ...]:
        views = []
        for index, body in enumerate(int(body) for body in self.trails.bodies):
            style = self._styles[body]
            if style.ghost is not None and self._model.present[world, body]:
                poses = self.trails.poses(world, index, every=style.ghost_every, length=style.ghost_length)
                views += [self._reader.ghost(world, body, pose, style.ghost, style.ghost_shape or "") for pose in poses]
        return tuple(views)
