"""IR-SIM's planners that draw points, as its scripts use them. The searches are OMPL's."""

from __future__ import annotations

import math
from abc import ABC
from dataclasses import dataclass, field
from typing import Any, ClassVar, final

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.base.arraytypes import Floats
from irsim_gym.live.planning.grid_map import GridMap
from irsim_gym.live.planning.path_planner import point
from irsim_gym.live.planning.planners import MapPlanner
from irsim_gym.live.planning.sampling import Place, Sampling, sampled_way
from irsim_gym.simulator.readings.irsim_readings import IrSimReadings


def _way(
    method: str, env_map: GridMap, core: Any, margin: float, ends: tuple[ArrayLike, ArrayLike], sampling: Sampling
) -> Floats:
    """Return a way inside of a map, beside obstacles and occupied cells, from goal to start, shape ``(2, n)`` [m].

    Args:
        method: One of ``SAMPLERS``.
        env_map: The map.
        core: What moves, without turning: a shapely geometry in its own frame, whose convex hull counts.
        margin: Distance that is kept around it [m].
        ends: Start and goal [m].
        sampling: How to draw points. ``longest`` holds for road maps, too.
    """
    import shapely

    hull, longest = shapely.get_coordinates(core), sampling.longest if method == "prm" else math.inf
    low = np.array(env_map.world_offset, np.float64)
    high = low + np.array([env_map.width, env_map.height])
    solid = list(shapely.get_parts([body.geometry for body in env_map.obstacle_list or ()]))
    if env_map.occupied is not None and env_map.grid_resolution is not None:
        corners = low + np.argwhere(env_map.occupied) * env_map.grid_resolution
        boxes: Any = shapely.box(*corners.T, *(corners + env_map.grid_resolution).T)
        solid += boxes.tolist()
    tree = shapely.STRtree(solid)

    def is_free(first: Place, second: Place) -> bool:
        swept = np.concatenate([hull + first, hull + second])
        if math.dist(first, second) > longest or (swept - margin < low).any() or (swept + margin > high).any():
            return False
        return not len(tree.query(shapely.convex_hull(shapely.linestrings(swept)), "dwithin", distance=margin))

    places = point(ends[0], "start_pose"), point(ends[1], "goal_pose")
    return sampled_way(method, (low.tolist(), high.tolist()), *places, is_free, sampling)[::-1].T


@dataclass(eq=False, repr=False)
class TreePlanner(MapPlanner, ABC):
    """A planner that grows a tree of motions.

    Motions are tested as a whole: the convex hull of the robot's outline, at heading 0, stays inside of the map and
    touches nothing.

    Attributes:
        env_map: Result of ``world.get_map``.
        robot: Its outline is what moves.
        expand_dis: Length of the longest motion [m].
        path_resolution: Ignored: motions are tested exactly.
        goal_sample_rate: How often the goal is aimed at [%].
        max_iter: Number of attempts to extend the tree.
        connect_circle_dist: Ignored: OMPL chooses how near branches are that are laid anew.
        search_until_max_iter: Shorten the way until the attempts are used up. ``RRT`` always ends at its first way.
        seed: The same seed gives the same way.
    """

    method: ClassVar[str]
    robot: IrSimReadings
    expand_dis: float = 1.0
    path_resolution: float = 0.25
    goal_sample_rate: float = 5
    max_iter: int = 500
    connect_circle_dist: float = 0.5
    search_until_max_iter: bool = False
    seed: int = field(default=0, kw_only=True)

    def planning(self, start_pose: ArrayLike, goal_pose: ArrayLike, show_animation: bool = True) -> Floats | None:
        """Return a way from the goal back to the start, shape ``(2, n)`` [m]; None if none is found.

        Args:
            start_pose: x, y and perhaps more [m], flat or a column.
            goal_pose: Likewise.
            show_animation: Ignored: nothing is shown.

        Raises:
            ValueError: A point is none, or there are no iterations.
            MissingExtraError: OMPL is not installed.
        """
        share, ends_early = self.goal_sample_rate / 100.0, not self.search_until_max_iter
        sampling = Sampling(self.max_iter, self.seed, self.expand_dis, share, ends_early=ends_early)
        core, margin = self.robot.original_geometry, 0.0
        if self.robot.shape == "circle":
            core, margin = core.centroid, self.robot.radius
        way = _way(self.method, self.env_map, core, margin, (start_pose, goal_pose), sampling)
        return way if way.size else None


@final
@dataclass(eq=False, repr=False)
class RRT(TreePlanner):
    """The first way that a random tree finds. Attributes are those of ``TreePlanner``."""

    method = "rrt"


@final
@dataclass(eq=False, repr=False)
class RRTStar(TreePlanner):
    """A way of a random tree whose branches may be laid anew. Attributes are those of ``TreePlanner``.

    Attributes:
        expand_dis: Length of the longest motion [m].
    """

    method = "rrt_star"
    expand_dis: float = 1.5


@final
@dataclass(eq=False, repr=False)
class InformedRRTStar(TreePlanner):
    """As ``RRTStar``, with points that may shorten the way. Attributes are those of ``TreePlanner``.

    Attributes:
        expand_dis: Length of the longest motion [m].
        goal_sample_rate: How often the goal is aimed at [%].
        search_until_max_iter: Shorten the way until the attempts are used up.
    """

    method = "informed_rrt_star"
    expand_dis: float = 1.5
    goal_sample_rate: float = 10
    search_until_max_iter: bool = True


@final
@dataclass(eq=False, repr=False)
class PRMPlanner(MapPlanner):
    """The shortest way over a road map of random points, for a disc.

    Attributes:
        env_map: Result of ``world.get_map``.
        robot_radius: Radius of the disc [m].
        n_sample: Number of points.
        n_knn: Number of nearest points that each is joined to.
        max_edge_len: Length of the longest motion [m].
        seed: The same seed gives the same way.
    """

    robot_radius: float
    n_sample: int = 500
    n_knn: int = 10
    max_edge_len: float = 30.0
    seed: int = field(default=0, kw_only=True)

    def planning(
        self, start_pose: ArrayLike, goal_pose: ArrayLike, rng: Any = None, show_animation: bool = True
    ) -> Floats:
        """Return a way from the goal back to the start, shape ``(2, n)`` [m]; without one, n is 0.

        Args:
            start_pose: x, y and perhaps more [m], flat or a column.
            goal_pose: Likewise.
            rng: A generator of NumPy, from which a seed is drawn instead of ``seed``.
            show_animation: Ignored: nothing is shown.

        Raises:
            ValueError: A point is none, or there are no points to draw.
            MissingExtraError: OMPL is not installed.
        """
        import shapely

        seed = self.seed if rng is None else int(rng.random() * 2**32)
        sampling = Sampling(self.n_sample, seed, self.max_edge_len, neighbors=self.n_knn)
        core = shapely.Point(0.0, 0.0)
        return _way("prm", self.env_map, core, self.robot_radius, (start_pose, goal_pose), sampling)
