"""What scripts for IR-SIM do beside the world's own methods: values as in ir-sim 2.12.0."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np
import pytest
from irsim.lib import algorithm
from irsim.lib.behavior import behavior_methods
from irsim.util import util as their_util
from shapely.geometry import LineString, Point, Polygon
from small_world import DIFF, SCENARIO, WALL, world

import irsim_gym.irsim as ours
from irsim_gym.base import families
from irsim_gym.errors import ScenarioError

SHAPES: list[dict[str, Any]] = [
    {"name": "circle", "radius": 0.4, "center": [0.1, 0.2]},
    {"name": "rectangle", "length": 2.0, "width": 0.6, "wheelbase": 1.0},
    {"name": "polygon", "vertices": [[0, 0], [2, 0], [1, 0.5], [0, 2]]},
    {"name": "linestring", "vertices": [[0, 0], [2, 0], [2, 1]]},
    {
        "name": "compound",
        "parts": [
            {"name": "rectangle", "length": 2.0, "width": 0.4},
            {"name": "rectangle", "length": 0.4, "width": 2.0, "pose": [0.5, 0.3, 0.2]},
            {"name": "circle", "radius": 0.5, "pose": [-1.0, 0, 0]},
        ],
    },
]
STATE = np.array([[1.5], [-2.0], [0.7]])


def columns(**sections: Any) -> Any:
    return ours.make({**SCENARIO, **sections})


def test_a_class_of_ones_own() -> None:
    class Trainer(ours.EnvBase):
        def __init__(self, source: Any) -> None:
            super().__init__(source, display=False, disable_all_plot=True)
            self.rewards: list[float] = []

        def step(self, *others: Any, **named: Any) -> None:
            super().step(*others, **named)
            self.rewards.append(float(self.robot.state[0, 0]))

    env = Trainer(SCENARIO)
    env.step(action_id=0, action=np.array([[0.5], [0.0]]))
    assert env.rewards == pytest.approx([1.05])
    assert isinstance(ours.make(SCENARIO), ours.EnvBase)
    assert ours.EnvBase3D is ours.EnvBase


def test_the_world_inside() -> None:
    here = columns(world={"width": 8, "height": 6, "offset": [-1, 2]})
    inside = here._world
    assert (inside.width, inside.height, inside.x_range, inside.y_range) == (8.0, 6.0, (-1.0, 7.0), (2.0, 8.0))
    assert (inside.step_time, inside.time, inside.count, inside.offset) == (0.1, 0.0, 0, [-1.0, 2.0])
    assert here._objects == here.objects
    assert (inside.name, inside.status, inside.sample_time, inside.sampling) == (here.name, "None", 0.1, True)
    with pytest.raises(AttributeError, match=r"_world has no 'grid_map': use get_map\(\) of the world itself"):
        _ = inside.grid_map
    with pytest.raises(AttributeError, match=r"_world has no 'step': use that of the world itself"):
        inside.step()


@pytest.mark.parametrize("by_hand", [True, False])
def test_a_step_after_a_collision_is_not_lost(by_hand: bool) -> None:
    here = columns(obstacle=WALL)
    robot = here.robot
    robot.set_state([5, 5, 0])
    here.step([0.1, 0.0])
    assert (robot.collision_flag, robot.stop_flag) == (True, True)
    robot.set_state([1.0, 1.0, 0.0])
    if by_hand:
        robot.collision_flag = robot.arrive_flag = robot.stop_flag = False
    else:
        robot.clear_flags()
    assert (robot.collided, robot.arrived, robot.stopped) == (False, False, False)
    here.step([0.5, 0.0])
    assert robot.state[0, 0] == pytest.approx(1.05)
    robot.arrive_flag = True
    assert here.robot.arrived
    assert here.done("any")


def test_a_state_that_is_assigned() -> None:
    robot = columns().robot
    assert robot._state.shape == (3, 1)
    robot._state = np.array([[2.0], [6.0], [0.5]])
    assert robot.state.ravel().tolist() == [2.0, 6.0, 0.5]
    with pytest.raises(ValueError, match=r"read-only: set_state, set_velocity and set_goal"):
        robot._state[0, 0] = 3.0
    with pytest.raises(ValueError, match=r"read-only: set_state"):
        world().robot.state[0] = 3.0
    robot.set_state(None)
    assert robot.state.ravel().tolist() == [0.0, 0.0, 0.0]


def test_one_robot_alone() -> None:
    here = columns()
    before, second = here.time, here[1].state
    for _ in range(4):
        moved = here.robot.step(np.array([[0.5], [9.0]]))  # a turn beyond its limit of 1 rad/s
    assert moved[2, 0] == pytest.approx(0.4)
    assert here.robot.velocity.ravel().tolist() == [0.5, 1.0]
    assert (here.time, here[1].state.tolist()) == (before, second.tolist())
    heading = here.robot.state[2, 0]
    here.robot.step()  # its behaviour turns to the goal
    assert here.robot.state[2, 0] > heading
    other = here[1]
    other.step([1.0, 0.0])
    assert other.state[0, 0] == pytest.approx(1.1)
    assert here.robots[1].step(None).ravel().tolist() == other.state.ravel().tolist()  # nothing drives it
    with pytest.raises(ValueError, match="2 numbers"):
        here.robot.step([1.0])
    wall = here["obstacle_2"]
    assert wall.step([1.0, 1.0]).tolist() == wall.state.tolist()


def test_scans_and_flags_by_themselves() -> None:
    here = columns(obstacle=WALL)
    robot = here.robot
    old = robot.lidar.range_data
    robot.set_state([3.5, 5, 0])
    assert robot.lidar.range_data.tolist() == old.tolist()
    robot.sensor_step()
    assert robot.lidar.range_data[2] == pytest.approx(0.9, abs=1e-6)  # from 3.6 to the wall at 4.5
    robot.set_state([4.5, 5, 0])
    assert not robot.collision
    robot.check_status()
    assert robot.collision
    assert here.count == 0


def test_a_lidar() -> None:
    here = columns(world={"width": 20})
    robot = here.robot
    here.step([0.2, 0.3])
    lidar, scan = robot.lidar, robot.get_lidar_scan()
    assert (lidar.sensor_type, lidar.number, lidar.range_max, lidar.obj_id) == ("lidar2d", 5, 6.0, 0)
    assert lidar.angle_list.tolist() == pytest.approx(np.linspace(-math.pi / 2, math.pi / 2, 5).tolist())
    assert (lidar.angle_min, lidar.angle_max) == (scan["angle_min"], scan["angle_max"])
    assert lidar.angle_inc == pytest.approx(math.pi / 4)
    assert lidar.range_data.tolist() == scan["ranges"].tolist() == lidar.get_scan()["ranges"].tolist()
    assert lidar.valid.tolist() == scan["valid"].tolist()
    assert (lidar.offset.tolist(), lidar.get_offset()) == ([[0.1], [0.0], [0.0]], [0.1, 0.0, 0.0])
    assert lidar.lidar_origin.ravel().tolist() == pytest.approx(
        [1.02 + 0.1 * math.cos(0.03), 1 + 0.1 * math.sin(0.03), 0.03]
    )
    assert lidar.parent == robot
    assert (lidar == robot.sensors[0], len({lidar, *robot.sensors})) == (True, 1)
    assert world().robot.sensors[0].offset == (0.1, 0.0, 0.0)
    assert here.robots[1].lidar is None
    with pytest.raises(AttributeError, match=r"a sensor 'lidar2d' has no 'rang_max' \(did you mean 'range_"):
        _ = lidar.rang_max


@pytest.mark.parametrize("shape", SHAPES, ids=[shape["name"] for shape in SHAPES])
def test_outlines_are_those_of_ir_sim(shape: dict[str, Any]) -> None:
    theirs, made = algorithm_outline(shape), ours.GeometryFactory.create_geometry(**shape)
    placed = theirs.step(STATE)
    assert made.step(STATE).equals_exact(placed, 1e-9) or made.geometry.symmetric_difference(placed).area < 1e-9
    assert made.geometry.geom_type == placed.geom_type
    assert made.radius == pytest.approx(theirs.radius, abs=1e-9)
    assert (made.length, made.width) == pytest.approx((theirs.length, theirs.width), abs=2e-3)  # a disc is exact
    here = columns(obstacle={"shape": shape, "state": STATE.ravel().tolist()})
    body = here.obstacle_list[0]
    assert body.geometry.symmetric_difference(placed).area < 1e-9
    assert body.geometry.hausdorff_distance(placed) < 1e-9
    assert body.original_geometry.hausdorff_distance(made.original_geometry) < 1e-9


def algorithm_outline(shape: dict[str, Any]) -> Any:
    from irsim.lib import GeometryFactory

    return GeometryFactory.create_geometry(**shape)


def test_outlines_that_cannot_be() -> None:
    with pytest.raises(ScenarioError, match="circel"):
        ours.GeometryFactory.create_geometry("circel")
    with pytest.raises(ValueError, match="drawn with a level"):
        ours.GeometryFactory.create_geometry("circle", random_shape=True)


def test_a_map_as_geometry() -> None:
    cells = [[0, 100, 0], [0, 0, 0]]  # columns from the left, rows from the bottom
    here = columns(
        world={"obstacle_map": cells, "width": 4, "height": 3}, robot=None, obstacle={**WALL, "state": [3, 1]}
    )
    found = here.get_map()
    assert here.obstacle_list[-1].geometry.equals(LineString([(0, 1), (2, 1), (2, 2), (0, 2), (0, 1)]))
    hits = [found.is_collision(Point(x, y).buffer(0.2)) for x, y in ((1, 1.5), (2.1, 1.5), (3, 1), (3, 2.5), (1, 0.5))]
    assert hits == [True, True, True, False, False]


def test_infos_keep_what_scripts_add() -> None:
    here = columns()
    here.robot.info.add_property("battery", 0.9)
    assert here.get_robot_info_list()[0].battery == 0.9
    with pytest.raises(AttributeError, match="an info has no 'battery'"):
        _ = here.robots[1].info.battery
    assert here.robot.beh_config["name"] == "dash"
    assert (here.robots[1].beh_config, here.robot.wander, here.robot.loop) == ({}, False, False)


def test_calls_that_change_nothing() -> None:
    here = columns(obstacle=WALL)
    before = here.get_robot_state().tolist()
    here.build_tree()
    here.validate_unique_names()
    here.random_polygon_shape(avg_radius_range=[0.1, 1])
    assert here.get_robot_state().tolist() == before
    triangle = {"shape": {"name": "polygon", "vertices": [[0, 0], [1, 0], [0, 1]]}, "state": [5, 5, 0]}
    with pytest.raises(ValueError, match=r"'obstacle_2' stays in this level.*random_shape: true"):
        columns(obstacle=triangle).random_polygon_shape()


def test_loggers_have_ir_sims_levels(caplog: pytest.LogCaptureFixture) -> None:
    logger = columns().logger
    with caplog.at_level("DEBUG"):
        logger.success("there")
        logger.trace("here")
        for _ in range(2):
            logger.warning_once("slow")
    assert [(record.levelname, record.message) for record in caplog.records] == [
        ("INFO", "there"),
        ("DEBUG", "here"),
        ("WARNING", "slow"),
    ]


POSES = [np.array(row).reshape(3, 1) for row in product((-1.0, 2.0), (0.3,), (-2.0, 0.05, 3.0))]
GOALS = [np.array([[2.1], [0.4], [1.0]]), np.array([[2.02], [0.3], [-3.0]]), np.array([[-4.0], [0.2], [0.0]])]
LIMITS = np.array([[1.0], [1.5], [0.8]])


@pytest.mark.parametrize("name", ["DiffDash", "OmniDash", "AckerDash", "OmniAngularDash"])
def test_dash_as_a_function(name: str) -> None:
    more: list[tuple[float, ...]] = [(0.2, 0.1)] if name == "AckerDash" else [(0.1,)] if name == "OmniDash" else []
    more = more or [(0.2, 0.15), (0.2, 0.1, 0.7, 0.1)]
    limits = LIMITS if name == "OmniAngularDash" else LIMITS[:2]
    for pose, goal, options in product(POSES, GOALS, more):
        expected = getattr(behavior_methods, name)(pose, goal, limits, *options)
        found = getattr(ours, name)(pose, goal, limits, *options)
        assert found.shape == expected.shape
        assert np.allclose(found, expected, rtol=0, atol=1e-12), (pose, goal, options)


@pytest.mark.parametrize("mode", ["rvo", "hrvo", "vo"])
def test_rvo_as_a_function(mode: str) -> None:
    random = np.random.default_rng(3)
    for k in range(12):
        state = [*random.uniform(-1, 1, 4), 0.3, *random.uniform(-1.5, 1.5, 2), random.uniform(-3, 3)]
        others = [[*random.uniform(-2, 2, 2), *random.uniform(-1, 1, 2), 0.3] for _ in range(k % 4)] + [[9, 9, 0, 0, 1]]
        walls = random.uniform(-3, 3, (k % 3, 4)).tolist()
        given = state, others, 1.5, 1.0, 0.7, 1.0, mode, 3.0, walls
        for name in ("OmniRVO", "DiffRVO"):
            expected = getattr(behavior_methods, name)(*given)
            assert np.allclose(getattr(ours, name)(*given), expected, rtol=0, atol=1e-9), (k, name)
    with pytest.raises(ValueError, match="mode must be"):
        ours.reciprocal_vel_obs(state).cal_vel("orca")
    still = ours.reciprocal_vel_obs(state, [[0.0, 5.0, 0.3]])
    assert still.cal_vel() == pytest.approx(algorithm.reciprocal_vel_obs(state, [[0.0, 5.0, 0.3]]).cal_vel())
    with pytest.raises(AttributeError, match=r"no 'config_rvo': cal_vel\(mode\)"):
        _ = still.config_rvo


def test_a_behaviour_that_calls_dash(monkeypatch: pytest.MonkeyPatch) -> None:
    families.load()
    monkeypatch.setattr(families.BEHAVIORS, "_entries", dict(families.BEHAVIORS._entries))

    @ours.register_behavior("diff", "half_speed_dash")
    def half_speed_dash(ego_object: Any, external_objects: list[Any], **kwargs: Any) -> Any:
        assert ego_object._state.shape == (3, 1)
        assert isinstance(ego_object.geometry, Polygon)
        fastest = ego_object.get_vel_range()[1]
        return 0.5 * ours.DiffDash(ego_object.state, ego_object.goal, fastest, ego_object.goal_threshold, 0.1)

    robot = {**DIFF, "state": [1, 1, 0], "goal": [7, 1, 0], "behavior": {"name": "half_speed_dash"}}
    here = columns(robot=robot, obstacle=None)
    for _ in range(10):
        here.step()
    assert here.robot.state[0, 0] == pytest.approx(1.5)


COLUMN = np.array([[0.7], [-0.4]])
SQUARE = np.array([[0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 2.0, 2.0]])


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        *[("WrapToPi", (angle,)) for angle in (4.0, -math.pi, math.inf, math.nan, np.array([[3.5]]))],
        ("WrapToPi", (-4.0, True)),
        *[(name, (angle,)) for name in ("WrapTo2Pi", "ClipTo2Pi") for angle in (-1.0, 7.0, math.nan, 2 * math.pi)],
        *[("WrapToRegion", (angle, [0.0, 2 * math.pi])) for angle in (-1.0, 7.0, 2 * math.pi, 20.0)],
        ("relative_position", (STATE, COLUMN)),
        ("distance", (STATE, COLUMN)),
        ("dist_hypot", (1.0, 2.0, 4.0, 6.0)),
        ("get_transform", (STATE,)),
        ("get_affine_transform", (STATE,)),
        ("transform_point_with_state", (STATE, -STATE)),
        ("vertices_transform", (SQUARE, STATE)),
        ("vel_world2omni", (0.7, COLUMN)),
        ("vel_omni2world", (0.7, COLUMN)),
        ("vel_diff2world", (0.7, COLUMN)),
        *[("vel_world2diff", (heading, COLUMN)) for heading in (-0.5, -0.52, 0.3, 3.0)],
        ("omni_to_diff", (0.7, 0.01 * COLUMN)),
        ("cross_product", ([0, 0], [1, 2], [3, 5])),
        *[(name, (corners,)) for name in ("is_convex_and_ordered", "gen_inequal_from_vertex")
          for corners in (SQUARE, SQUARE[:, ::-1])],
        ("is_convex_and_ordered", (SQUARE[:, [0, 2, 1, 3]],)),
        ("to_numpy", ([1, 2, 3],)),
        *[("is_2d_list", (data,)) for data in ([], [1, 2], [[1, 2]], np.zeros((2, 2)))],
    ],
)  # fmt: skip
def test_small_functions(name: str, arguments: tuple[Any, ...]) -> None:
    expected, found = getattr(their_util, name)(*arguments), getattr(ours, name)(*arguments)
    if isinstance(expected, str | bool) or (isinstance(expected, tuple) and isinstance(expected[0], bool)):
        assert found == expected
        return
    pairs = [(found, expected)] if not isinstance(expected, tuple) else zip(found, expected, strict=True)
    for one, another in pairs:
        assert np.shape(one) == np.shape(another)
        assert np.allclose(one, another, rtol=0, atol=1e-12)


def test_arrays_of_angles() -> None:
    wrapped = ours.WrapToPi(np.array([4.0, math.nan, -math.pi]))
    assert wrapped.tolist() == pytest.approx([4.0 - 2 * math.pi, 0.0, -math.pi])
    assert isinstance(ours.WrapToPi(4.0), float)
    with pytest.raises(ValueError, match="a full turn"):
        ours.WrapToRegion(1.0, [0.0, 1.0])


def test_geometries_are_moved() -> None:
    moved = ours.geometry_transform(Point(1, 0), [1.0, 2.0, math.pi / 2])
    assert (moved.x, moved.y) == pytest.approx((1.0, 3.0))
    assert moved.distance(their_util.geometry_transform(Point(1, 0), [1.0, 2.0, math.pi / 2])) < 1e-12
