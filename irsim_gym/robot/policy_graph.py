"""A whole policy as one graph: from what a robot measures to its command in SI units."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.envs.parts.spaces import observed
from irsim_gym.evaluation.saved_policies.shelf import ShelfPolicy
from irsim_gym.robot.inputs import limits_of, robot_values, scanner_form, seen_map_form
from irsim_gym.robot.network_graph import network_graph
from irsim_gym.robot.prediction import pending_spans, predicted
from irsim_gym.simulator.world.model import OMNI_WORLD
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.actions.discrete import DiscreteAction
from irsim_gym.tasks.actions.velocity import VelocityAction
from irsim_gym.tasks.observations.seen_map.way_on_seen_map import WayOnSeenMap
from irsim_gym.tasks.terms.graph import Graph, HasGraph, RobotValues, Value
from irsim_gym.tasks.terms.term import NEEDS, IsImage, Term

ALONE = ("scan", "odometry", "map_frame")
"""What a graph can be fed with from the robot's own messages; also with a way on a map of them by ``perceive.py``, and
with the rows of a tracker where a twin takes other bodies so."""


class UnfitForRobotError(IrsimGymError):
    """Raised for policies that cannot leave the simulator as one graph."""


@dataclass(frozen=True)
class PolicyGraph:
    """A policy as ONNX.

    Attributes:
        content: The bytes of its file.
        starts: What each of its states is before the first step, without the axis of the batch.
        n_nodes: Number of its nodes.
        perceives: What ``SeenMap`` needs of a contract, if the graph takes a way on a seen map; else None.
    """

    content: bytes
    starts: dict[str, NDArray[Any]]
    n_nodes: int
    perceives: dict[str, Any] | None


def policy_graph(
    policy: ShelfPolicy, episodes: Episodes, name: str, *, predict: float = 0.0, period: float | None = None
) -> PolicyGraph:
    """Return a policy as a graph, for the first agent of some episodes.

    Args:
        predict: Time from the measurement until a new command acts [s]; 0 for none.
        period: Time from one command to the next [s]; None for a step.

    Raises:
        UnfitForRobotError: It observes or acts in a way that a graph cannot; the message names all of these.
    """
    reasons = list(_reasons(episodes))
    if reasons:
        raise UnfitForRobotError(f"'{name}' cannot leave as one graph: {'; '.join(reasons)}")
    graph, model, b = Graph(), episodes.simulation.model, episodes.task.agents[0]
    low, high = limits_of(episodes)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    still = np.clip(-middle / np.where(half > 0.0, half, 1.0), -1.0, 1.0)
    robot = robot_values(graph, episodes, graph.state("action", still.astype(np.float32)))
    measured = robot
    if predict > 0.0:
        robot, pending = predicted(robot, episodes, pending_spans(predict, period or float(model.step_time[0])))
    action = _action(network_graph(policy, graph, _seen(episodes, robot)), episodes)
    command = action * half + middle
    if model.drive[b] == OMNI_WORLD and episodes.task.action.frame == "command":
        heading = measured.pose.columns(2, 3)
        cosine, sine, x, y = heading.op("Cos"), heading.op("Sin"), command.columns(0, 1), command.columns(1, 2)
        command = graph.join([cosine * x + sine * y, cosine * y - sine * x])
    if predict > 0.0:
        n_pending = len(graph.starts["pending"])
        graph.keep("pending", graph.join([pending.columns(1, n_pending), command.spread(1)]))
    graph.keep("action", action.cast(np.float32))
    graph.output("command", command.cast(np.float32), len(low))
    found = graph.model(name)
    return PolicyGraph(found.SerializeToString(), graph.starts, len(found.graph.node), perceived_by(episodes))


def perceived_by(episodes: Episodes) -> dict[str, Any] | None:
    """Return what ``SeenMap`` needs of a contract; None where no way on a seen map is observed."""
    scan, seen_map = scanner_form(episodes), seen_map_form(episodes)
    return {"scan": scan.model_dump(), "seen_map": seen_map.model_dump()} if scan and seen_map else None


def _reasons(episodes: Episodes) -> Iterator[str]:
    """Yield why the observations or the action cannot be computed in a graph."""
    for term in episodes.terms["observations"]:
        yield from _term_reasons(term)
    if not isinstance(episodes.task.action, VelocityAction | DiscreteAction):
        yield f"its action '{episodes.terms['action'][0].name}' has no twin in ONNX operators"
    if len(set(episodes.action_sizes.tolist())) > 1:
        yield "its team has drives with different numbers of components"


def _term_reasons(term: Term) -> Iterator[str]:
    needs = term.options.needs
    if needs is None:
        yield f"the observation '{term.name}' does not say what it needs: declare 'needs'"
        return
    fed = "grid" if isinstance(term.options, WayOnSeenMap) else "bodies" if isinstance(term.options, HasGraph) else ""
    lacking = [f"{need} ({NEEDS[need]})" for need in needs if need not in (*ALONE, fed)]
    if lacking:
        yield f"the observation '{term.name}' needs {', '.join(lacking)}"
    elif isinstance(term.options, IsImage):
        yield f"the observation '{term.name}' is a picture"
    elif not isinstance(term.options, HasGraph):
        yield f"the observation '{term.name}' has no twin in ONNX operators: no method 'graph'"


def _seen(episodes: Episodes, robot: RobotValues) -> dict[str, Value]:
    """Return the parts of the observation by their names, as the policy takes them."""
    parts: dict[str, list[Value]] = {}
    for key, term in observed(episodes):
        columns = term.options.graph(term, episodes.simulation.model, 0, robot)
        parts.setdefault(key, []).append(columns)
    return {key: robot.graph.join(columns) for key, columns in parts.items()}


def _action(found: Value, episodes: Episodes) -> Value:
    """Return the action in [-1, 1], float64."""
    if not episodes.n_discrete:
        return found.between(-1.0, 1.0)
    grid = found.graph.constant(episodes.terms["action"][0].arrays["grid"][0])
    return found.graph.op("Gather", [grid, found], np.float64, axis=0)
