"""A small world made by hand: a robot with a lidar, a goal, fixed and moving obstacles, walls."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np

from irsim_gym.rendering import Renderer
from irsim_gym.scenario.specs.plot_spec import MOVING_OBSTACLE_COLOR, OBSTACLE_COLOR, ObjectPlot, WorldPlot
from irsim_gym.simulator.world.group import Group
from irsim_gym.simulator.world.model import OBSTACLE, ROBOT, Model
from irsim_gym.simulator.world.outline import Outline, chain
from irsim_gym.simulator.world.state import State

N_BEAMS = 24


@dataclass
class Body:
    """One body of a hand-made world."""

    outline: Outline
    pose: tuple[float, float, float] = (0.0, 0.0, 0.0)
    robot: bool = False
    movable: bool = False
    goal: tuple[float, float] | None = None
    color: str | None = None
    plot: ObjectPlot = field(default_factory=ObjectPlot)
    fov: float | None = None
    fov_radius: float | None = None


@dataclass
class World:
    """The arrays of a batch of equal worlds and what a renderer needs to know of them."""

    scenario: Any
    model: Model
    state: State
    sensors: list[Group]

    def renderer(self, **options: Any) -> Renderer:
        return Renderer(self.scenario, self.model, self.state, self.sensors, **options)

    def move(self, body: int, x: float, y: float, heading: float = 0.0) -> None:
        """Put a body somewhere in every world and write its outline there."""
        model, state = self.model, self.state
        for w in range(state.pose.shape[0]):
            state.pose[w, body] = x, y, heading
            rows = slice(model.segment_start[body], model.segment_start[body] + model.segment_count[0, body])
            local = model.local_segments[0, rows]
            turn = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
            state.segments[w, rows] = np.hstack([local[:, :2] @ turn + [x, y], local[:, 2:] @ turn + [x, y]])
            rows = slice(model.disc_start[body], model.disc_start[body] + model.disc_count[0, body])
            local = model.local_discs[0, rows]
            state.discs[w, rows] = np.hstack([local[:, :2] @ turn + [x, y], local[:, 2:]])

    def step(self) -> None:
        self.state.step += 1
        self.state.time += 0.1


def disc(radius: float) -> Outline:
    return Outline(discs=np.array([[0.0, 0.0, radius]]))


def polygon(*vertices: tuple[float, float]) -> Outline:
    return Outline(segments=chain(np.array(vertices), closed=True))


def box(length: float, width: float) -> Outline:
    x, y = length / 2, width / 2
    return polygon((-x, -y), (x, -y), (x, y), (-x, y))


def wall(*vertices: tuple[float, float]) -> Outline:
    return Outline(segments=chain(np.array(vertices), closed=False), solid=False)


def make_world(
    bodies: list[Body],
    bounds: tuple[float, float, float, float] = (0.0, 0.0, 10.0, 10.0),
    n_worlds: int = 1,
    lidar: bool = True,
    plot: WorldPlot | None = None,
) -> World:
    sizes = defaultdict(  # any axis that a picture does not ask for has length 1
        lambda: 1,
        world=n_worlds,
        body=len(bodies),
        segment=sum(len(body.outline.segments) for body in bodies),
        disc=sum(len(body.outline.discs) for body in bodies),
        waypoint=1,
    )
    model, state = Model.allocate(sizes), State.allocate(sizes)
    model.bounds[:], model.step_time[:] = bounds, 0.1
    model.goal_threshold[:] = 0.3
    segment = disc_row = 0
    for b, body in enumerate(bodies):
        segments, discs = body.outline.segments, body.outline.discs
        model.role[b] = ROBOT if body.robot else OBSTACLE
        model.movable[b], model.solid[b], model.has_goal[b] = body.movable, body.outline.solid, body.goal is not None
        model.present[:, b] = True
        model.segment_start[b], model.segment_count[0, b] = segment, len(segments)
        model.disc_start[b], model.disc_count[0, b] = disc_row, len(discs)
        model.local_segments[0, segment : segment + len(segments)] = segments
        model.local_discs[0, disc_row : disc_row + len(discs)] = discs
        segment, disc_row = segment + len(segments), disc_row + len(discs)
        model.start[:, b] = body.pose
        state.goal[:, b, :2] = body.goal or (0.0, 0.0)
        model.waypoint_count[:, b] = body.goal is not None
    state.hit[:] = -1
    model.map_frame["body"] = -1
    world = World(_scenario(bodies, plot or WorldPlot()), model, state, [])
    for b, body in enumerate(bodies):
        world.move(b, *body.pose)
    if lidar:
        world.sensors.append(_lidar(n_worlds))
    return world


def _scenario(bodies: list[Body], plot: WorldPlot) -> Any:
    specs = [
        SimpleNamespace(
            name=f"{'robot' if body.robot else 'obstacle'}_{b}",
            role="robot" if body.robot else "obstacle",
            static=not body.movable,
            color=body.color or (MOVING_OBSTACLE_COLOR if body.movable else OBSTACLE_COLOR),
            plot=body.plot,
            kinematics=None,
            description=None,
            sensors=(),
            fov=body.fov,
            fov_radius=body.fov_radius,
        )
        for b, body in enumerate(bodies)
    ]
    return SimpleNamespace(name="hand_made", world=SimpleNamespace(plot=plot), bodies=tuple(specs))


def _lidar(n_worlds: int) -> Group:
    options = [SimpleNamespace(range_max=2.0, offset=(0.0, 0.0, 0.0), color="#CC3311", alpha=0.3)]
    ranges = np.full((n_worlds, 1, N_BEAMS), 2.0, np.float32)
    ranges[:, :, : N_BEAMS // 3] = 1.0
    arrays = {"angles": np.linspace(-np.pi, np.pi, N_BEAMS), "ranges": ranges}
    return Group(SimpleNamespace, options, np.array([0]), params=np.zeros(1), arrays=arrays)


SHOWN = ObjectPlot(show_goal=True, show_trajectory=True)


def standard_world() -> World:
    return make_world(
        [
            Body(disc(0.4), (2.0, 3.0, 0.0), robot=True, movable=True, goal=(8.0, 8.0), color="#009E73", plot=SHOWN),
            Body(box(2.0, 1.0), (7.0, 3.0, 0.0)),
            Body(disc(0.5), (5.0, 7.0, 0.0), color="#AA00FF"),
            Body(polygon((-0.6, -0.6), (0.6, -0.6), (0.0, 0.8)), (3.0, 8.0, 0.0), movable=True),
            Body(wall((0.0, 0.0), (10.0, 0.0), (10.0, 10.0))),
        ]
    )
