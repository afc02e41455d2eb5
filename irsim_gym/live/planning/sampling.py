"""Ways over random points. OMPL draws the points; which motions are free is decided here."""

import math
from collections.abc import Callable, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.extras import require

Place = tuple[float, float]
IsFree = Callable[[Place, Place], bool]
"""Whether a straight motion between two places [m], which may be the same, touches nothing."""

SAMPLERS = MappingProxyType({"rrt": "RRT", "rrt_star": "RRTstar", "informed_rrt_star": "InformedRRTstar", "prm": "PRM"})
"""OMPL's planners, by method."""
TRIES = 3
"""How often OMPL may ask, per point of a road map, whether to go on. It asks twice, and after 200 blocked points."""


class Sampling(NamedTuple):
    """How to draw points.

    Attributes:
        iterations: Number of attempts to extend a tree; of a road map the number of its points.
        seed: The same seed gives the same way.
        longest: Length of the longest motion of a tree [m], 0 for a fifth of the diagonal of the area.
        goal_share: Share of attempts of a tree that aim at the goal, without unit.
        neighbors: Number of points that a point of a road map is joined to.
        ends_early: End at the first way, also where later ones are shorter.
    """

    iterations: int = 1000
    seed: int = 0
    longest: float = 0.0
    goal_share: float = 0.05
    neighbors: int = 10
    ends_early: bool = False


def sampled_way(
    method: str, area: Sequence[Sequence[float]], start: Place, goal: Place, is_free: IsFree, sampling: Sampling
) -> Floats:
    """Return the points of a way, shape ``(n, 2)`` [m]; no points if none is found.

    Time does not decide: the number of attempts ends the search. OMPL's generator, which the process shares, is seeded.

    Args:
        method: One of ``SAMPLERS``.
        area: Lower left and upper right corner of where points are drawn [m].
        start: x, y [m].
        goal: x, y [m].
        is_free: Decides which motions are free.
        sampling: How to draw points.

    Raises:
        ValueError: There are no iterations.
        MissingExtraError: OMPL is not installed.
    """
    if sampling.iterations < 1:
        raise ValueError(f"iterations must be >= 1, got {sampling.iterations!r}")
    require("ompl", f"the method '{method}'")
    if not (is_free(start, start) and is_free(goal, goal)):
        return np.zeros((0, 2))
    from ompl import base, geometric, util

    level = util.getLogLevel()
    util.setLogLevel(util.LOG_NONE)
    try:
        util.RNG.setSeed(1 + sampling.seed % (2**32 - 1))
        space = base.RealVectorStateSpace(0)
        for low, high in zip(*area, strict=True):
            space.addDimension(low, high)
        problem = _problem(base, space, is_free, start, goal)
        if sampling.ends_early:
            problem.getOptimizationObjective().setCostThreshold(base.Cost(math.inf))
        planner = getattr(geometric, SAMPLERS[method])(problem.getSpaceInformation())
        planner.setProblemDefinition(problem)
        _search(base, planner, sampling, is_road_map=method == "prm")
    finally:
        util.setLogLevel(level)
    if not problem.hasSolution() or problem.getSolutionDifference() > 0.0:  # a tree that ends beside the goal is none
        return np.zeros((0, 2))
    path = problem.getSolutionPath()
    return np.array([path.getState(i)[0:2] for i in range(path.getStateCount())])


def _problem(base: Any, space: Any, is_free: IsFree, start: Place, goal: Place) -> Any:
    """Return OMPL's description of the problem: the shortest way on motions that are free."""

    class Motions(base.MotionValidator):  # type: ignore[misc]
        def checkMotion(self, first: Any, second: Any) -> bool:  # noqa: N802 - OMPL's name
            return is_free((first[0], first[1]), (second[0], second[1]))

    information = base.SpaceInformation(space)
    information.setMotionValidator(Motions(information))
    information.setStateValidityChecker(lambda state: is_free((state[0], state[1]), (state[0], state[1])))
    information.setup()
    problem = base.ProblemDefinition(information)
    ends = space.allocState(), space.allocState()
    for state, place in zip(ends, (start, goal), strict=True):
        state[0:2] = place
    problem.setStartAndGoalStates(*ends)
    problem.setOptimizationObjective(base.PathLengthOptimizationObjective(information))
    return problem


def _search(base: Any, planner: Any, sampling: Sampling, *, is_road_map: bool) -> None:
    """Search until the attempts are used up."""
    attempts = iter(range(sampling.iterations * (TRIES if is_road_map else 1)))

    def is_over() -> bool:
        return next(attempts, None) is None or (is_road_map and planner.milestoneCount() >= sampling.iterations)

    if is_road_map:
        planner.setMaxNearestNeighbors(sampling.neighbors)
        planner.setup()
        planner.growRoadmapPtc(base.PlannerTerminationCondition(is_over))
        # PRM.solve grows the map in one thread and looks for a way in another, so that time would decide. Ended at
        # once, it joins start and goal to the map and returns the way to the goal, or to the point nearest to it.
        planner.solve(base.plannerAlwaysTerminatingCondition())
    else:
        planner.setRange(sampling.longest)
        planner.setGoalBias(sampling.goal_share)
        planner.setup()
        planner.solve(base.PlannerTerminationCondition(is_over))
