"""Ways through a world by hand, and its map for planners."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import networkx
import numpy as np
import pytest
import shapely

import irsim_gym
from irsim_gym.errors import NoEffectWarning
from irsim_gym.irsim import AStarPlanner, JPSPlanner, WrapTo2Pi, WrapToPi, relative_position

DISC: dict[str, Any] = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.3}}
BLOCK = {"shape": {"name": "rectangle", "length": 2, "width": 4}, "state": [5, 4, 0]}
WALL = {"shape": {"name": "linestring", "vertices": [[5, 0], [5, 7]]}, "state": [0, 0, 0]}


def world(*obstacles: Any, robot: Any = None, **keys: Any) -> Any:
    robots = {"robot": [{**DISC, "state": [1, 1, 0], **(robot or {})}]}
    return irsim_gym.load({"world": {"height": 10, "width": 10, **keys}, **robots, "obstacle": list(obstacles)})


def length(points: Any) -> float:
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def test_a_free_way_is_straight() -> None:
    here = world({**DISC, "state": [5, 5, 0]}, robot={"goal": [9, 9]})  # a body that can move is not in the way
    assert here.path([1, 1], [9, 9]).tolist() == [[1, 1], [9, 9]]
    assert here.path(here.robot.state, here.robot.goal).tolist() == [[1, 1], [9, 9]]
    assert here.path(np.array([[1.0], [1.0], [0.5]]), [[9.0], [9.0]]).tolist() == [[1, 1], [9, 9]]


@pytest.mark.parametrize("radius", [0.0, 0.3, 0.8])
def test_a_way_around_a_block_has_the_length_worked_out_by_hand(radius: float) -> None:
    """Around both upper corners, (4, 6) and (6, 6): two tangents, two arcs, and the straight way between them.

    From (2, 4) the corner is at a distance of sqrt(8) under 45 degrees; the tangent to the disc of the radius about it
    is sqrt(8 - r^2) long and steeper by asin(r / sqrt(8)); the arc turns from there to level.
    """
    tangent, angle = math.sqrt(8 - radius**2), math.pi / 4 + math.asin(radius / math.sqrt(8))
    expected = 2 * (tangent + radius * angle) + 2
    way = world(BLOCK).path([2, 4], [8, 4], radius)
    assert way[0].tolist() == [2, 4]
    assert way[-1].tolist() == [8, 4]
    assert expected * (1 - 1e-9) <= length(way) <= expected * 1.005
    assert shapely.LineString(way).distance(shapely.box(4, 2, 6, 6)) >= radius - 1e-9


def test_plan_takes_worlds_and_scenarios() -> None:
    """The same way as ``path``, in a world as it stands and in a level of a scenario; clearance adds to the radius."""
    here = world(BLOCK)
    assert irsim_gym.plan(here, [2, 4], [8, 4]).tolist() == here.path([2, 4], [8, 4], 0.3).tolist()
    assert irsim_gym.plan(here, [2, 4], [8, 4], clearance=0.2).tolist() == here.path([2, 4], [8, 4], 0.5).tolist()
    assert irsim_gym.plan(here, [2, 4], [8, 4], robot="robot_0", radius=0.1).shape[1] == 2
    drawn = irsim_gym.load("cluttered_room", seed=3)
    ends = drawn.robot.state, drawn.robot.goal
    assert irsim_gym.plan("cluttered_room", *ends, seed=3).tolist() == irsim_gym.plan(drawn, *ends).tolist()


@pytest.mark.parametrize(
    ("start", "goal", "options", "words"),
    [
        ([5, 4], [8, 4], {}, r"the start \(5, 4\) is nearer than 0.3 m to 'obstacle_1'"),
        ([2, 4], [5, 6.2], {}, r"the goal \(5, 6.2\) is nearer than 0.3 m to 'obstacle_1'"),
        ([2, 4], [8, 4], {"clearance": 4.0}, r"the start .* nearer than 4.3 m to 'obstacle_1'"),
        ([2, 9], [9, 1], {}, r"no way for a disc of radius 0.3 m from \(2, 9\) to \(9, 1\): take a smaller radius"),
        ([2, 4], [8, 4], {"clearance": -1.0}, "clearance must be >= 0"),
        ([2, 4], [8, 4], {"seed": 1}, "leave seed out"),
        ([2], [8, 4], {}, "start must be x and y"),
        ([2, 4], [8, 4], {"robot": "nobody"}, "nobody"),
    ],
)
def test_plan_says_why_there_is_no_way(start: Any, goal: Any, options: Any, words: str) -> None:
    around = [{"shape": {"name": "linestring", "vertices": [[8, 0], [8, 2], [10, 2]]}}]
    with pytest.raises((ValueError, KeyError), match=words):
        irsim_gym.plan(world(BLOCK, *around), start, goal, **options)


def test_plan_names_a_point_outside_of_the_world() -> None:
    told = r"the goal \(14, 5\) is outside of the world, x from 0 to 10 and y from 0 to 10 m, and no straight way"
    with pytest.raises(irsim_gym.errors.NoWayError, match=told):
        irsim_gym.plan(world(WALL), [1, 1], [14, 5])


def test_plan_names_the_map() -> None:
    cells = {"name": "array", "cells": [[0, 0, 0], [0, 100, 0], [0, 0, 0]]}
    with pytest.raises(
        irsim_gym.errors.NoWayError, match=r"the goal \(5, 5\) is nearer than 0.3 m to the obstacle map"
    ):
        irsim_gym.plan(world(obstacle_map=cells), [1, 1], [5, 5])


def test_the_first_robots_size_is_the_default() -> None:
    here = world(WALL)
    assert shapely.LineString(here.path([1, 1], [9, 1])).distance(shapely.LineString([(5, 0), (5, 7)])) >= 0.3 - 1e-9
    offset = {"shape": {"name": "rectangle", "length": 0.8, "width": 0.6}}  # its corners are 0.5 m away
    way = world(WALL, robot=offset).path([1, 1], [9, 1])
    assert shapely.LineString(way).distance(shapely.LineString([(5, 0), (5, 7)])) >= 0.5 - 1e-9


@pytest.mark.parametrize(("gap", "is_wide"), [(0.7, True), (0.59, False)])
def test_a_gap_lets_through_what_fits(gap: float, is_wide: bool) -> None:
    upper = {"shape": {"name": "linestring", "vertices": [[5, 4 + gap], [5, 10]]}, "state": [0, 0, 0]}
    lower = {"shape": {"name": "linestring", "vertices": [[5, 0], [5, 4]]}, "state": [0, 0, 0]}
    way = world(upper, lower).path([2, 2], [8, 2], 0.3)
    assert (way is not None) == is_wide


@pytest.mark.parametrize(
    ("start", "goal"), [([5, 4], [9, 9]), ([1, 1], [5, 4]), ([3.8, 4], [1, 1]), ([1, 1], [6.2, 4])]
)
def test_there_is_no_way_from_or_to_where_it_cannot_stand(start: Any, goal: Any) -> None:
    assert world(BLOCK).path(start, goal, 0.3) is None


def test_the_map_and_added_bodies_are_in_the_way() -> None:
    cells = [[0, 0, 0, 0, 0], [100, 100, 100, 100, 0], [0, 0, 0, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 0, 0]]
    here = world(obstacle_map=cells)  # the cells x = 2 to 4 m are occupied up to y = 8 m
    way = here.path([1, 1], [5, 1], 0.4)
    tangent, angle = math.sqrt(50 - 0.16), math.atan2(7, 1) + math.asin(0.4 / math.sqrt(50))
    expected = 2 * (tangent + 0.4 * angle) + 2
    assert expected * (1 - 1e-9) <= length(way) <= expected * 1.005
    assert shapely.LineString(way).distance(shapely.box(2, 0, 4, 8)) >= 0.4 - 1e-9
    here.add("obstacle", shape={"name": "circle", "radius": 1.2}, state=[3, 9, 0])
    assert here.path([1, 1], [5, 1], 0.4) is None


def test_unobstructed_bodies_are_not_in_the_way_and_static_robots_are() -> None:
    assert len(world({**BLOCK, "unobstructed": True}).path([2, 4], [8, 4])) == 2
    standing = {"robot": [{**DISC, "state": [1, 1, 0]}, {**DISC, "static": True, "state": [5, 1, 0]}]}
    way = irsim_gym.load({"world": {"height": 10, "width": 10}, **standing}).path([3, 1], [7, 1])
    assert shapely.LineString(way).distance(shapely.Point(5, 1)) >= 0.6 - 1e-9


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (([1], [2, 2]), r"start must be x and y \[m\], got \[1\]"),
        (([1, 1], "there"), r"goal must be x and y \[m\], got 'there'"),
        (([1, 1], [2, np.nan]), "goal must be"),
        (([1, 1], [2, 2], -0.1), "radius must be >= 0 and resolution > 0, got -0.1"),
        (([1, 1], [2, 2], np.inf), "got inf"),
    ],
)
def test_what_is_no_point_or_size_is_told(arguments: Any, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        world().path(*arguments)


def test_cells_are_those_that_something_touches() -> None:
    """Compared with shapely's intersections of squares and shapes."""
    shapes = [
        {"shape": {"name": "circle", "radius": 0.83}, "state": [2.1, 2.2, 0]},
        {"shape": {"name": "polygon", "vertices": [[0, 0], [2.3, 0.2], [0.4, 1.9]]}, "state": [5, 1, 0.4]},
        {"shape": {"name": "linestring", "vertices": [[0, 0], [3, 1], [3.2, 2.7]]}, "state": [1, 6, 0.1]},
        {"shape": {"name": "rectangle", "length": 0.8, "width": 1.2}, "state": [8.5, 0.3, 0]},
        {"shape": {"name": "rectangle", "length": 0.8, "width": 1.0}, "state": [8, 7, 0]},  # ends on edges of cells
        {"shape": {"name": "linestring", "vertices": [[0, 0], [0, 1.1]]}, "state": [6, 4.1, 0]},  # lies on one
        {**DISC, "state": [4, 4.5, 0]},
    ]
    here = world(*shapes, offset=[-1, -2], width=12, height=11)
    cells = here.get_map(0.2, bodies=True)
    assert (cells.width, cells.height, cells.world_offset, cells.grid.shape) == (12, 11, (-1, -2), (60, 55))
    assert cells.grid_resolution == pytest.approx((0.2, 0.2))
    bodies = []
    for body in here.static_objects:
        if body.shape == "circle":
            bodies.append(shapely.Point(body.position).buffer(body.radius, 256))
        elif body.shape == "linestring":
            bodies.append(shapely.LineString([*body.segments[:, :2], body.segments[-1, 2:]]))
        else:
            bodies.append(shapely.Polygon(body.vertices))
    whole = shapely.union_all(bodies)
    touched = np.zeros((60, 55), bool)
    for i in range(60):
        for j in range(55):
            x, y = -1 + 0.2 * i, -2 + 0.2 * j
            touched[i, j] = shapely.box(x, y, x + 0.2, y + 0.2).distance(whole) < 1e-9
    assert 200 < touched.sum() < 1000
    np.testing.assert_array_equal(cells.occupied, touched)


def test_the_map_keeps_its_cells_or_is_made_coarser() -> None:
    drawn = np.zeros((8, 4))
    drawn[2, 1] = drawn[5, 3] = 100
    here = world({**BLOCK, "state": [7, 2, 0]}, obstacle_map=drawn.tolist(), width=8, height=4)
    cells = here.get_map()
    assert (cells.resolution, cells.grid_resolution, cells.world_offset) == (0.1, (1.0, 1.0), (0.0, 0.0))
    np.testing.assert_array_equal(cells.grid, drawn)
    assert [body.shape for body in cells.obstacle_list] == ["rectangle", "map"]
    assert np.argwhere(here.get_map(2.0).occupied).tolist() == [[1, 0], [2, 1]]
    with pytest.warns(NoEffectWarning, match="resolution 0.5 m is finer than the obstacle map: .* 1 x 1 m"):
        fine = here.get_map(0.5)
    assert fine.grid.shape == (8, 4)
    assert here.get_map(0.5, bodies=True).occupied[4:6, 2:4].all()
    assert here.get_map(bodies=True).occupied[6:, :].all()  # the block covers x = 6 to 8 m
    assert cells.grid_occupied(2.5, 1.5)
    assert not cells.grid_occupied(3.5, 1.5)
    assert cells.grid_occupied(3.5, 1.5, margin_x=0.2)
    assert not cells.grid_occupied(3.5, 1.5, margin_y=0.2)
    assert cells.grid_occupied(-0.1, 1.5)
    assert cells.grid_occupied(2.5, 4.0)


def test_without_an_obstacle_map_there_is_no_grid_and_bodies_collide_where_they_are() -> None:
    here = world({**DISC, "state": [5, 5, 0]}, robot={"state": [1, 1, 0]})
    cells = here.get_map(0.5)
    assert (cells.grid, cells.grid_resolution, cells.occupied, cells.grid_occupied(5, 5)) == (None,) * 4
    disc = shapely.Point(5.6, 5).buffer(0.2)
    assert not cells.is_collision(disc)
    assert not cells.is_collision(shapely.Point(1, 1))  # robots are no obstacles
    assert cells.is_collision(shapely.Point(10, 5))  # the upper edges of the world are outside, the lower ones inside
    assert not cells.is_collision(shapely.Point(0, 5))
    here["obstacle_1"].set_state([5.2, 5, 0])
    here.refresh()
    assert cells.is_collision(disc)


@pytest.mark.parametrize(("resolution", "said"), [(0, "must be > 0"), (-1.0, "must be > 0"), (1e-4, "too small")])
def test_cells_that_cannot_be_are_told(resolution: float, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        world().get_map(resolution)


def shortest_over(free: Any, start: tuple[int, int], goal: tuple[int, int]) -> float:
    """Return the length in cells of a shortest way over free nodes, worked out by networkx."""
    nodes = {(int(i), int(j)) for i, j in np.argwhere(free)}
    graph = networkx.Graph()
    for i, j in nodes:
        for di, dj in [(1, 0), (0, 1), (1, 1), (1, -1)]:
            if (i + di, j + dj) in nodes:
                graph.add_edge((i, j), (i + di, j + dj), weight=math.hypot(di, dj))
    return float(networkx.dijkstra_path_length(graph, start, goal))


def test_a_star_finds_the_shortest_way_over_cells() -> None:
    here = world(
        BLOCK, {**WALL, "state": [3, 0, 0]}, {"shape": {"name": "circle", "radius": 0.9}, "state": [2.5, 6, 0]}
    )
    way = AStarPlanner(here.get_map(0.25)).planning(here.robot.state, [8.4, 4.1], show_animation=True)
    assert (way[:, 0].tolist(), way[:, -1].tolist()) == ([8.5, 4.0], [1, 1])  # from the goal back, as IR-SIM's
    bodies = shapely.union_all([body.geometry for body in here.obstacles])
    free = np.zeros((40, 40), bool)
    for i in range(1, 40):  # the squares around nodes of index 0 lie partly outside
        for j in range(1, 40):
            x, y = 0.25 * i, 0.25 * j
            free[i, j] = not shapely.box(x - 0.125, y - 0.125, x + 0.125, y + 0.125).intersects(bodies)
    nodes = way.T / 0.25
    assert free[tuple(nodes.astype(int).T)].all()
    assert np.abs(np.diff(nodes, axis=0)).max() == 1.0
    assert length(nodes) == pytest.approx(shortest_over(free, (4, 4), (34, 16)))
    jumps = JPSPlanner(here.get_map(0.25)).planning(here.robot.state, [8.4, 4.1])
    assert jumps is not None
    assert jumps.tolist() == way.tolist()


def test_planners_without_a_way() -> None:
    """A* then returns the goal alone, and jump point search None, as IR-SIM's do."""
    cells = world(BLOCK).get_map(0.25)
    for start, goal in ([1, 1], [5, 4]), ([1, 1], [11, 1]), ([1, 1], [1, 1]):
        assert AStarPlanner(cells).planning(start, goal).T.tolist() == [goal]
        assert JPSPlanner(cells).planning(start, goal) is None
    assert JPSPlanner(cells).planning([5, 4], [1, 1]) is None
    with pytest.raises(ValueError, match="goal_pose must be x and y"):
        AStarPlanner(cells).planning([1, 1], [9])
    with pytest.raises(AttributeError, match=r"a planner has no 'motion': planning\(start, goal\)"):
        AStarPlanner(cells).motion  # noqa: B018
    cells.resolution = 1e-4
    with pytest.raises(ValueError, match="too small"):
        AStarPlanner(cells).planning([1, 1], [9, 9])


def test_a_grid_may_be_written_into() -> None:
    cells = world(obstacle_map=np.zeros((40, 40)).tolist()).get_map(0.25)
    cells.grid[:, 20] = 100
    assert AStarPlanner(cells).planning([1, 1], [1, 9]).shape == (2, 1)
    assert JPSPlanner(cells).planning([1, 1], [1, 9]) is None
    cells.grid[38:, 20] = 0  # a node needs both cells beside it
    assert JPSPlanner(cells).planning([1, 1], [1, 9]) is not None
    assert AStarPlanner(cells).planning([1, 1], [1, 9]).shape[1] > 40


YARDS = {
    "bodies": """
world: {height: 6, width: 7.3, offset: [-1.5, 2.25]}
obstacle:
  - {shape: {name: circle, radius: 0.75}, state: [1, 4, 0.3]}
  - {shape: {name: rectangle, length: 1.5, width: 0.5}, state: [3, 5.5, 1.5707963267948966]}
  - shape: {name: polygon, vertices: [[-0.5, -0.5], [1, -0.25], [0.2, 0.5]]}
    state: [4, 7, 0.8]
    kinematics: {name: diff}
  - {shape: {name: linestring, vertices: [[0, 0], [0.7, 0.7], [1.4, 0]]}, state: [0, 6, 0]}
  - shape: {name: compound, parts: [{name: circle, radius: 0.4}, {name: rectangle, length: 1.2, width: 0.2}]}
    state: [2.5, 3, 0.4]
""",
    "map": """
world: {height: 6, width: 5.5, obstacle_map: {name: perlin, resolution: 0.1, seed: 6, complexity: 0.12, fill: 0.1}}
obstacle: [{shape: {name: rectangle, length: 1, width: 0.3}, state: [3, 3, 0.5]}]
""",
    "coarse map": """
world: {height: 6, width: 6, obstacle_map: {name: perlin, resolution: 0.5, seed: 8, complexity: 0.2, fill: 0.2}}
""",
}


@pytest.mark.parametrize("yard", YARDS)
@pytest.mark.filterwarnings("ignore")  # IR-SIM warns of resolutions, and so does irsim_gym
def test_maps_and_ways_are_irsims(yard: str, tmp_path: Path) -> None:
    """Grids, collisions and the ways of both planners, in installed ir-sim and here, on the same file.

    Where ir-sim's jump point search takes a detour, the way here is shorter.
    """
    irsim = pytest.importorskip("irsim")
    from irsim.lib import path_planners

    file = tmp_path / "yard.yaml"
    file.write_text(YARDS[yard] + "robot: {kinematics: {name: diff}, shape: {name: circle, radius: 0.1}}\n")
    env = irsim.make(str(file), headless=True, log_level="CRITICAL")
    here = irsim_gym.load(file)
    rng = np.random.default_rng(5)
    found = 0
    for resolution in [(), (0.4,), (0.25,)]:
        theirs, ours = env.get_map(*resolution), here.get_map(*resolution)
        for name in ("width", "height", "resolution", "world_offset", "grid_resolution"):
            assert getattr(ours, name) == getattr(theirs, name), name
        assert (ours.grid is None) == (theirs.grid is None)
        if theirs.grid is not None:
            np.testing.assert_array_equal(ours.occupied, theirs.grid > 50)
        low, size = np.array(ours.world_offset), np.array([ours.width, ours.height])
        for x, y in low + rng.uniform(-0.05, 1.05, (60, 2)) * size:
            x, y = np.round([x, y], 1) if rng.uniform() < 0.5 else (x, y)  # also exactly on edges
            shape = shapely.Point(x, y).buffer(0.2) if rng.uniform() < 0.5 else shapely.box(x, y, x + 0.3, y + 0.1)
            assert ours.is_collision(shape) == theirs.is_collision(shape), shape
            assert ours.grid_occupied(x, y, 0.1, 0.3) == theirs.grid_occupied(x, y, 0.1, 0.3)
        for name in ("AStarPlanner", "JPSPlanner") if resolution else ():
            for ends in low + rng.uniform(0.05, 0.95, (3, 2, 2)) * size:
                expected = getattr(path_planners, name)(theirs).planning(*ends, show_animation=False)
                way = getattr(irsim_gym.irsim, name)(ours).planning(*ends)
                assert (way is None) == (expected is None)
                if expected is None:
                    continue
                found += way.shape[1] > 3
                if name == "AStarPlanner":
                    np.testing.assert_allclose(way, expected, rtol=0, atol=1e-9)
                else:
                    np.testing.assert_allclose(way[:, [0, -1]], expected[:, [0, -1]], rtol=0, atol=1e-9)
                    assert length(way.T) <= length(expected.T) + 1e-9
    env.end()
    assert found > 2


def test_names_of_planners_that_are_not_here_say_what_to_use() -> None:
    with pytest.raises(ImportError, match=r"no 'GridPlannerBase': planning\(start, goal\) is all that planners do"):
        from irsim_gym.irsim import GridPlannerBase  # noqa: F401
    with pytest.raises(AttributeError, match=r"no attribute 'AStarPlaner' \(did you mean 'AStarPlanner'\?\)"):
        irsim_gym.irsim.AStarPlaner  # noqa: B018


def test_small_functions_are_irsims() -> None:
    theirs = pytest.importorskip("irsim.util.util")
    for angle in (0.0, 3.0, np.pi, -np.pi, 4.0, -4.0, 10.0, np.inf, np.nan):
        assert WrapToPi(angle) == theirs.WrapToPi(angle)
        assert WrapToPi(angle, positive=True) == theirs.WrapToPi(angle, positive=True)
        assert WrapTo2Pi(angle) == theirs.WrapTo2Pi(angle)
    here = np.array([[1.0], [2.0], [0.3]])
    for there in ([[4.0], [6.0]], [[-2.0], [2.0]], [[1.0], [-5.0]]):
        expected = theirs.relative_position(here, np.array(there))
        assert relative_position(here, np.array(there)) == expected
        assert relative_position([1, 2], np.ravel(there)) == expected
    assert relative_position([0, 0], [-1, 0], topi=False) == (1.0, np.pi)


@pytest.mark.parametrize("name", ["pursuit", "hybrid_astar"])
def test_a_body_whose_planner_finds_no_way_is_named_once(name: str) -> None:
    here = world(BLOCK, robot={"goal": [5, 4], "behavior": {"name": name}})
    with pytest.warns(UserWarning, match=r"'robot_0' stands: its behavior finds no way to \(5, 4\)"):
        here.step()
    here.step()  # warnings are errors: it is told once
    assert here.robot.state.tolist() == [1, 1, 0]
    here.robot.set_goal([1, 9])
    here.step()  # there is a way now
