"""Reads a scene from the arrays of a simulation; it writes nothing."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np

from irsim_gym.arraytypes import Bytes, Flags, Floats
from irsim_gym.render import theme
from irsim_gym.render.images import load_image
from irsim_gym.render.outlines import NOTHING, arrow, box, chains, placed, replaced, wedge, windscreen
from irsim_gym.render.scene import (
    BodyView,
    FieldView,
    FogView,
    GoalView,
    ImageView,
    LabelView,
    MapView,
    ScanView,
    Scene,
    TrailView,
)
from irsim_gym.render.styles import BodyStyle, body_style, field_of_view, is_omni, scan_style
from irsim_gym.scenario.images import image_file
from irsim_gym.scenario.plot_spec import trailing
from irsim_gym.world.group import Group
from irsim_gym.world.model import ACKERMANN, ROBOT, WorldModel
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
        self._turns_with_motion = [is_omni(body) for body in scenario.bodies]
        self._fields = {b: field_of_view(body) for b, body in enumerate(scenario.bodies) if self._styles[b].show_field}
        self._pixels = {
            b: load_image(image_file(body.description, scenario.file))
            for b, body in enumerate(scenario.bodies)
            if body.description is not None
        }
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
        moving = tuple(self._body_view(world, body) for body in self._moving_bodies if model.present[world, body])
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
            labels=_labels(fixed + moving, goals),
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

    def _rows(self, world: int, body: int) -> tuple[slice, slice]:
        """Return the body's rows in the tables of segments and of discs."""
        model = self._model
        segment, disc = int(model.segment_start[body]), int(model.disc_start[body])
        segments = int(model.segment_count[world % len(model.segment_count), body])
        discs = int(model.disc_count[world % len(model.disc_count), body])
        return slice(segment, segment + segments), slice(disc, disc + discs)

    def _fixed_views(self, world: int) -> tuple[BodyView, ...]:
        """Return the views of the fixed bodies, the same tuple until one of their outlines changes."""
        model, state = self._model, self._state
        bodies = [body for body in self._fixed_bodies if model.present[world, body]]
        parts = [np.array(bodies).tobytes()]
        for body in bodies:
            segments, discs = self._rows(world, body)
            parts += [state.segments[world, segments].tobytes(), state.discs[world, discs].tobytes()]
        key = b"|".join(parts)
        known = self._fixed.pop(world, None)
        if known is None or known[0] != key:
            known = key, tuple(self._body_view(world, body) for body in bodies)
            if len(self._fixed) >= REMEMBERED_WORLDS:
                self._fixed.pop(next(iter(self._fixed)))
        self._fixed[world] = known
        return known[1]

    def _body_view(self, world: int, body: int) -> BodyView:
        state, style = self._state, self._styles[body]
        segment_rows, disc_rows = self._rows(world, body)
        segments, discs = state.segments[world, segment_rows].copy(), state.discs[world, disc_rows].copy()
        return BodyView(
            body=body,
            name=self._names[body],
            lines=chains(segments),
            discs=discs,
            solid=bool(self._model.solid[body]),
            heading=self._heading(world, body, segment_rows, disc_rows) if style.show_arrow else NOTHING,
            anchor=_anchor(state.pose[world, body], style, segments, discs),
            style=style,
            image=self._image(world, body, self._pixels[body]) if body in self._pixels else None,
        )

    def _image(self, world: int, body: int, pixels: Bytes) -> ImageView | None:
        """Return the image of a body over the rectangle around its footprint; None without a footprint."""
        model, (segment_rows, disc_rows) = self._model, self._rows(world, body)
        segments = model.local_segments[world % len(model.local_segments), segment_rows]
        extent = box(segments, model.local_discs[world % len(model.local_discs), disc_rows])
        if extent is None:
            return None
        x_min, y_min, x_max, y_max = extent
        corners = np.array([[x_min, y_min], [x_max, y_min], [x_max, y_max], [x_min, y_max]])
        return ImageView(pixels, placed(corners, self._state.pose[world, body]), self._styles[body].image_alpha)

    def _heading(self, world: int, body: int, segment_rows: slice, disc_rows: slice) -> Floats:
        model, style, pose = self._model, self._styles[body], self._state.pose[world, body]
        if self._turns_with_motion[body] and self._state.twist[world, body, :2].any():
            x, y = self._state.twist[world, body, :2]
            pose = np.array([pose[0], pose[1], np.arctan2(y, x)])
        if style.arrow is not None:
            return placed(arrow(*style.arrow), pose)
        segments = model.local_segments[world % len(model.local_segments), segment_rows]
        discs = model.local_discs[world % len(model.local_discs), disc_rows]
        is_car = model.drive[body] == ACKERMANN and len(segments) > 0 and body not in self._pixels
        return placed(windscreen(segments, discs) if is_car else wedge(segments, discs), pose)

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
                views += [self._ghost(world, body, pose, style.ghost, style.ghost_shape or "") for pose in poses]
        return tuple(views)

    def _ghost(self, world: int, body: int, pose: Floats, style: BodyStyle, shape: str) -> BodyView:
        """Return the body as it stood at a pose, or a simpler shape around it."""
        model, (segment_rows, disc_rows) = self._model, self._rows(world, body)
        segments = model.local_segments[world % len(model.local_segments), segment_rows]
        discs = model.local_discs[world % len(model.local_discs), disc_rows]
        if shape:
            segments, discs = replaced(shape, segments, discs)
        return BodyView(
            body=body,
            name=self._names[body],
            lines=tuple(placed(line, pose) for line in chains(segments)),
            discs=np.hstack([placed(discs[:, :2], pose), discs[:, 2:]]),
            solid=shape != "linestring" and (bool(shape) or bool(model.solid[body])),
            heading=NOTHING,
            anchor=(float(pose[0]), float(pose[1])),
            style=style,
        )


def _anchor(pose: Floats, style: BodyStyle, segments: Floats, discs: Floats) -> tuple[float, float]:
    """Return where a body's label stands: at the chosen offset, or above the footprint."""
    x, y = float(pose[0]), float(pose[1])
    if style.label_offset is not None:
        return x + style.label_offset[0], y + style.label_offset[1]
    extent = box(segments, discs)
    return (x, y) if extent is None else (0.5 * (extent[0] + extent[2]), extent[3] + 0.08)


def _foot(view: BodyView) -> float | None:
    """Return the lowest ordinate of a footprint; None without one."""
    lowest = [float(line[:, 1].min()) for line in view.lines] + [float(y - radius) for _, y, radius in view.discs]
    return min(lowest, default=None)


def _labels(bodies: Sequence[BodyView], goals: Sequence[GoalView]) -> tuple[LabelView, ...]:
    """Return the texts beside bodies and below goals."""
    beside = [
        LabelView(*view.anchor, view.style.label, view.style, None if view.style.label_offset else _foot(view))
        for view in bodies
        if view.style.label
    ]
    below = [
        LabelView(view.x, view.y, view.style.goal_label, view.style, view.y - view.tolerance)  # its own flag is there
        for view in goals
        if view.style.goal_label
    ]
    return tuple(beside + below)
