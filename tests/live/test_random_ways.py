"""Ways by other methods than the shortest: over cells, and over random points, which OMPL draws."""

from __future__ import annotations

import contextlib
import io
import math
import re
from pathlib import Path
from typing import Any

import networkx
import numpy as np
import pytest
import shapely

import irsim_gym
from irsim_gym.base import extras
from irsim_gym.errors import MissingExtraError
from irsim_gym.irsim import RRT, InformedRRTStar, PRMPlanner, RRTStar
from irsim_gym.live.planning.sampling import SAMPLERS, Sampling, sampled_way

DISC: dict[str, Any] = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.3}}
BLOCK = {"shape": {"name": "rectangle", "length": 2, "width": 4}, "state": [5, 4, 0]}
POST = {"shape": {"name": "circle", "radius": 0.8}, "state": [5, 8, 0]}
SHORTEST = 2 * (math.sqrt(8 - 0.3**2) + 0.3 * (math.pi / 4 + math.asin(0.3 / math.sqrt(8)))) + 2
"""From (2, 4) to (8, 4) around the upper corners of the block, as in ``test_plans``."""

random_points = pytest.mark.parametrize("method", SAMPLERS)


def world(*obstacles: Any, robot: Any = None, **keys: Any) -> Any:
    robots = {"robot": [{**DISC, "state": [1, 1, 0], "goal": [9, 9], **(robot or {})}]}
    return irsim_gym.load({"world": {"height": 10, "width": 10, **keys}, **robots, "obstacle": list(obstacles)})


def length(points: Any) -> float:
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


@pytest.fixture
def ompl() -> None:
    pytest.importorskip("ompl", reason='OMPL is not installed: pip install "irsim_gym[ompl]"')


@random_points
@pytest.mark.usefixtures("ompl")
def test_a_way_over_random_points_is_free_and_the_same_for_the_same_seed(method: str) -> None:
    cells = np.zeros((10, 10))
    cells[4:6, 0:2] = 100
    here = world(BLOCK, POST, {**DISC, "state": [3, 8, 0]}, obstacle_map=cells.tolist())
    solid = shapely.union_all([shapely.box(4, 2, 6, 6), shapely.box(4, 0, 6, 2), shapely.Point(5, 8).buffer(0.8, 256)])
    ways = [here.path([2, 4], [8, 4], method=method, iterations=300, seed=seed) for seed in (3, 3, 4)]
    for way in ways:
        assert (way[0].tolist(), way[-1].tolist()) == ([2, 4], [8, 4])
        assert shapely.LineString(way).distance(solid) >= 0.3 - 1e-9
        assert length(way) >= SHORTEST - 1e-9
        assert ((way >= 0) & (way <= 10)).all()
    assert ways[0].tolist() == ways[1].tolist()
    assert ways[0].tolist() != ways[2].tolist()


@pytest.mark.usefixtures("ompl")
def test_more_iterations_shorten_the_way_of_the_planners_that_go_on() -> None:
    """The tree of the same seed grows on: its best way never gets longer, and comes near to the shortest one."""
    here = world(BLOCK)
    for method in ("rrt_star", "informed_rrt_star"):
        lengths = [length(here.path([2, 4], [8, 4], method=method, iterations=n)) for n in (300, 600, 1500)]
        assert lengths == sorted(lengths, reverse=True)
        assert SHORTEST - 1e-9 <= lengths[-1] <= 1.03 * SHORTEST
    first = here.path([2, 4], [8, 4], method="rrt", iterations=3000)
    assert first.tolist() == here.path([2, 4], [8, 4], method="rrt", iterations=2000).tolist()


@random_points
@pytest.mark.usefixtures("ompl")
def test_without_a_way_the_search_ends_after_its_iterations(method: str) -> None:
    wall = {"shape": {"name": "linestring", "vertices": [[5, 0], [5, 10]]}, "state": [0, 0, 0]}
    here = world(wall)
    assert here.path([1, 1], [9, 1], method=method, iterations=100) is None
    assert here.path([4.8, 1], [1, 1], method=method, iterations=50) is None  # the disc cannot stand there
    assert here.path([1, 1], [5.2, 1], method=method, iterations=50) is None
    assert here.path([-1, 1], [1, 1], method=method, iterations=50) is None  # points are drawn in the world
    asked: list[Any] = []

    def is_free(*motion: Any) -> bool:
        asked.append(motion)
        return motion[0] == motion[1] and motion[0] in ((1.0, 1.0), (9.0, 9.0))  # nothing but the ends is free

    way = sampled_way(method, ((0.0, 0.0), (10.0, 10.0)), (1.0, 1.0), (9.0, 9.0), is_free, Sampling(iterations=50))
    assert way.shape == (0, 2)
    assert 50 <= len(asked) <= 50 * 3 * 200 + 4


@pytest.mark.usefixtures("ompl")
def test_errors_of_a_state_check_come_through_and_the_log_level_of_ompl_stays() -> None:
    from ompl import util

    level = util.getLogLevel()

    def is_free(*motion: Any) -> bool:
        raise RuntimeError("no state")

    with pytest.raises(RuntimeError, match="no state"):
        sampled_way("rrt", ((0.0, 0.0), (1.0, 1.0)), (0.1, 0.1), (0.9, 0.9), is_free, Sampling())
    assert util.getLogLevel() == level


@pytest.mark.parametrize("method", ["astar", "jps"])
def test_ways_over_cells_are_the_shortest_ones(method: str) -> None:
    """Compared with networkx, over the centres around which a disc of sqrt(r^2 + h^2 / 2) is free, by shapely."""
    here, side = world(BLOCK, POST), 0.25
    way = here.path([2.1, 4.05], [8, 4], method=method, resolution=side)
    assert (way[0].tolist(), way[-1].tolist()) == ([2.1, 4.05], [8, 4])
    solid = shapely.union_all([shapely.box(4, 2, 6, 6), shapely.Point(5, 8).buffer(0.8, 256)])
    assert shapely.LineString(way).distance(solid) >= 0.3 - 1e-9
    indices = way[1:-1] / side - 0.5
    np.testing.assert_allclose(indices, np.round(indices), atol=1e-9)
    graph, wide = networkx.Graph(), math.sqrt(0.3**2 + side**2 / 2)
    free = {(i, j) for i in range(40) for j in range(40) if solid.distance(_centre(i, j, side)) > wide}
    for i, j in free:
        for k, m in ((1, 0), (0, 1), (1, 1), (1, -1)):
            if (i + k, j + m) in free:
                graph.add_edge((i, j), (i + k, j + m), weight=side * math.hypot(k, m))
    ends = [tuple(np.round(indices[i]).astype(int).tolist()) for i in (0, -1)]
    assert length(way[1:-1]) == pytest.approx(networkx.dijkstra_path_length(graph, *ends))
    assert [math.dist(way[i], way[j]) < side for i, j in ((0, 1), (-1, -2))] == [True, True]


def _centre(i: int, j: int, side: float) -> shapely.Point:
    return shapely.Point((i + 0.5) * side, (j + 0.5) * side)


def test_ways_over_cells_at_their_limits() -> None:
    here = world(BLOCK)
    assert here.path([5, 4], [8, 4], method="astar") is None
    assert here.path([1, 1], [5, 4], method="astar") is None
    assert here.path([5, 3], [5, 5], method="astar") is None
    assert here.path([1.01, 1], [1.02, 1], method="astar", resolution=1.0)[[0, -1]].tolist() == [[1.01, 1], [1.02, 1]]
    wall = {"shape": {"name": "linestring", "vertices": [[5, 0], [5, 10]]}, "state": [0, 0, 0]}
    assert world(wall).path([1, 1], [9, 1], method="jps") is None


def test_unknown_methods_and_missing_packages_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    here = world()
    with pytest.raises(ValueError, match=r"unknown method 'rrtstar': one of shortest, astar, .*, prm finds a path"):
        here.path([1, 1], [9, 9], method="rrtstar")
    with pytest.raises(ValueError, match="iterations must be >= 1, got 0"):
        here.path([1, 1], [9, 9], method="rrt", iterations=0)
    monkeypatch.setattr(extras, "find_spec", lambda name: None)
    told = "the method 'prm' needs the extra 'ompl' (ompl not found): pip install \"irsim_gym[ompl]\""
    with pytest.raises(MissingExtraError, match=f"^{re.escape(told)}$"):
        here.path([1, 1], [9, 9], method="prm")
    with pytest.raises(MissingExtraError, match="the method 'rrt_star' needs"):
        RRTStar(here.get_map(), robot=here.robot).planning([1, 1], [9, 9])
    assert len(here.path([1, 1], [9, 9])) == 2  # the shortest path needs no package


@pytest.mark.usefixtures("ompl")
def test_planners_heed_the_map_and_their_arguments() -> None:
    here = world(BLOCK, robot={"shape": {"name": "rectangle", "length": 1.0, "width": 0.4}})
    cells = here.get_map()
    way = RRT(cells, robot=here.robot, expand_dis=0.7, max_iter=4000, seed=1).planning(here.robot.state, [[9], [1]])
    assert way is not None
    assert (way[:, 0].tolist(), way[:, -1].tolist()) == ([9, 1], [1, 1])
    assert np.hypot(*np.diff(way)).max() <= 0.7 + 1e-9
    body = shapely.box(-0.5, -0.2, 0.5, 0.2)
    for first, second in zip(way.T[:-1], way.T[1:], strict=True):
        swept = shapely.MultiPoint(
            [*(shapely.get_coordinates(body) + first), *(shapely.get_coordinates(body) + second)]
        )
        assert not swept.convex_hull.intersects(shapely.box(4, 2, 6, 6))
        assert shapely.box(0, 0, 10, 10).covers(swept.convex_hull)
    early = RRTStar(cells, here.robot, max_iter=1500).planning([1, 1], [9, 1])
    late = RRTStar(cells, here.robot, max_iter=1500, search_until_max_iter=True).planning([1, 1], [9, 1])
    assert early is not None
    assert late is not None
    assert length(late.T) < length(early.T)
    long = PRMPlanner(cells, 0.2, n_sample=150).planning([1, 1], [1, 9], np.random.default_rng(3))
    short = PRMPlanner(cells, 0.2, 150, max_edge_len=1.5).planning([1, 1], [1, 9], np.random.default_rng(3))
    assert np.hypot(*np.diff(short)).max() <= 1.5 < np.hypot(*np.diff(long)).max() + 0.5
    assert PRMPlanner(cells, 0.2).planning([1, 1], [5, 4]).shape == (2, 0)
    assert InformedRRTStar(cells, here.robot).planning([1, 1], [5, 4]) is None
    with pytest.raises(AttributeError, match="a planner has no 'node_list'"):
        RRT(cells, here.robot).node_list  # noqa: B018
    drawn = world(obstacle_map=np.zeros((20, 20)).tolist()).get_map()
    drawn.grid[:, 10] = 100  # a grid may be written into
    assert PRMPlanner(drawn, 0.1, 100).planning([1, 1], [1, 9]).shape == (2, 0)
    drawn.grid[4, 10] = 0
    assert PRMPlanner(drawn, 0.1, 400).planning([1, 1], [1, 9]).shape[1] > 2


SCRIPT = """
import irsim
from irsim.lib.path_planners import {planner}

env = irsim.make("{file}"{options})
planner = {planner}(env.get_map(), {moving})
way = planner.planning(env.get_robot_state(), env.get_robot_info().goal, show_animation=False)
if way is not None and len(way[0]):
    env.draw_trajectory(way, traj_type="r-")
for _ in range(2):
    env.step()
    env.render()
env.end(0)
"""


@pytest.mark.usefixtures("ompl")
@pytest.mark.parametrize("planner", ["RRT", "RRTStar", "InformedRRTStar", "PRMPlanner"])
@pytest.mark.filterwarnings("ignore")  # IR-SIM's own
def test_a_script_of_irsim_runs(planner: str, tmp_path: Path) -> None:
    """The same script with both packages: a way of shape (2, n) from the goal back to the start."""
    file = tmp_path / "yard.yaml"
    file.write_text("""
world: {height: 10, width: 10, step_time: 0.1}
robot: {kinematics: {name: diff}, shape: {name: circle, radius: 0.2}, state: [1, 1, 0], goal: [9, 6, 0]}
obstacle: [{shape: {name: rectangle, length: 1, width: 4}, state: [5, 3, 0.2]}]
""")
    moving = "robot_radius=0.2, n_sample=100" if planner == "PRMPlanner" else "robot=env.robot, max_iter=1500"
    ours = SCRIPT.replace("import irsim\n", "import irsim_gym.irsim as irsim\n")
    ours = ours.replace("from irsim.", "from irsim_gym.irsim.")
    ways = []
    for text, options in ((ours, ""), (SCRIPT, ", headless=True, log_level='CRITICAL'")):
        names: dict[str, Any] = {}
        with contextlib.redirect_stdout(io.StringIO()):
            exec(text.format(planner=planner, file=file.as_posix(), moving=moving, options=options), names)
        ways.append(names["way"])
    for way in ways:
        assert way.shape[0] == 2
        assert way[:, [0, -1]].T.tolist() == [[9, 6], [1, 1]]
    assert type(ways[0]) is type(ways[1])
    assert length(ways[0].T) < 2.5 * math.hypot(8, 5)
