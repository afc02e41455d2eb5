"""Observations as ONNX graphs: equal to their kernels on random episodes, far from the origin, and for broken scans."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from irsim_gym.base import families
from irsim_gym.robot.inputs import measured, robot_values
from irsim_gym.robot.parts.perceive import SeenMap
from irsim_gym.robot.policy_graph import perceived_by
from irsim_gym.robot.prediction import pending_spans, predicted
from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.engine import compile
from irsim_gym.simulator.world.model import OMNI_WORLD
from irsim_gym.tasks import Episodes, load_task
from irsim_gym.tasks.terms.graph import Graph, HasGraph

onnx = pytest.importorskip("onnx")
onnxruntime = pytest.importorskip("onnxruntime")

N_WORLDS, TOLERANCE = 8, 1e-5
SCANNER = {"name": "lidar2d", "number": 90, "angle_range": 2 * np.pi, "range_max": 4, "offset": [0.1, 0.05, 0.3]}
DISC = {"shape": {"name": "circle", "radius": 0.2}, "goal_threshold": 0.3, "sensors": [SCANNER]}
DIFF = {"kinematics": {"name": "diff"}, "vel_min": [-0.2, -1.5], "vel_max": [1, 1.5], **DISC}
OMNI = {"kinematics": {"name": "omni"}, "vel_min": [-1, -0.5], "vel_max": [1, 0.5], **DISC}
CAR = {
    "kinematics": {"name": "acker", "mode": "steer"},
    "vel_min": [-0.8, -0.6],
    "vel_max": [1, 0.6],
    "acce": [1.5, 2.0],
    **DISC,
    "shape": {"name": "rectangle", "length": 0.9, "width": 0.5, "wheelbase": 0.5},
}
CAR_BY_RATE = {**DIFF, "kinematics": {"name": "acker", "mode": "angular"}, "shape": CAR["shape"]}
FOLLOWED: list[Any] = [
    {"name": "tracks", "count": 3, "range": 3.0},
    {"name": "time_to_tracks", "directions": 7, "speeds": 3, "range": 2.5, "margin": 0.1},
]
EVERYTHING: list[Any] = [
    "scan",
    "free_travel",
    {"name": "past_scans", "ago": [1, 4]},
    "goal",
    "goal_record",
    {"name": "trail", "spacing": 0.1, "marks": 12},
    "goal_heading",
    "velocity",
    "last_action",
    {"name": "pending", "steps": 3},
    "drive",
    "own_body",
    "position",
    "heading",
    "way_on_seen_map",
    {"name": "nearest_bodies", "count": 2},
    "time_to_collision",
]
OTHERWISE: list[Any] = [
    {"name": "scan", "sectors": 90, "code": "linear"},
    {"name": "free_travel", "directions": 7, "margin": 0.1, "code": "linear", "horizon": 9},
    {"name": "past_scans", "sectors": 5, "code": "linear"},
    {"name": "goal", "scale": 3.0, "near": 0.4},
    {"name": "trail", "sectors": 1, "spacing": 0.2, "marks": 5, "fresh": 0},
    {"name": "way_on_seen_map", "cell": 0.21, "every": 3, "clearance": 0.1},
    {"name": "pending", "steps": 1},
    {"name": "nearest_bodies", "count": 5, "range": 3.0, "moving": True, "code": "linear", "speed": 0.5},
    {"name": "time_to_collision", "directions": 7, "speeds": 3, "range": 2.5, "moving": True, "margin": 0.1},
]
WANDER = {"name": "dash", "wander": True, "range_low": [0.5, 0.5, -3.1], "range_high": [5.5, 5.5, 3.1]}
MOVING = {"kinematics": {"name": "diff"}, "behavior": WANDER, "vel_max": [1, 3]}


def episodes(
    robot: dict[str, Any], observations: list[Any], shift: float = 0.0, predict: float = 0.0, **others: Any
) -> Episodes:
    """Return episodes of a robot among three discs, in a world whose corner is at ``shift`` [m] in x and y.

    ``others`` are more keys of the discs.
    """
    low, high = [shift + 0.5, shift + 0.5, -3.1], [shift + 5.5, shift + 5.5, 3.1]
    place = {"name": "random", "range_low": low, "range_high": high}
    obstacle = {"number": 3, "shape": {"name": "circle", "radius": 0.4}, "distribution": place, **others}
    world = {"width": 6, "height": 6, "offset": [shift, shift], "step_time": 0.1}
    scenario = load_scenario({"world": world, "robot": {**robot, "distribution": place}, "obstacle": obstacle})
    chosen = {"name": "blank", "observations": observations, "max_steps": 10_000, "predict": predict}
    task = load_task(scenario, chosen)
    played = Episodes(compile(scenario, N_WORLDS, agents=task.agents), task)
    played.begin(np.arange(N_WORLDS), np.arange(N_WORLDS))
    return played


class Twin:
    """The observations of episodes as a graph, which is run for all worlds at once; ``predict`` is that of its task."""

    def __init__(self, played: Episodes) -> None:
        graph, self.played = Graph(), played
        robot = robot_values(graph, played, graph.input("action", np.float32, int(played.action_sizes[0])))
        spans = pending_spans(float(played.task.predict), 0.1)
        if spans:
            robot, _ = predicted(robot, played, spans)
            self.under_way = np.stack([graph.starts.pop("pending")] * N_WORLDS)
        terms = played.terms["observations"]
        columns = [term.options.graph(term, played.simulation.model, 0, robot) for term in terms]
        graph.output("seen", graph.join(columns), played.n_features)
        model = graph.model("twin")
        onnx.checker.check_model(model, full_check=True)
        self.session = onnxruntime.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])
        self.names = {one.name for one in self.session.get_inputs()}
        self.states = {name: np.stack([start] * N_WORLDS) for name, start in graph.starts.items()}
        self.maps = [SeenMap(forms) for _ in range(N_WORLDS) if (forms := perceived_by(played))]

    def see(self, **changed: Any) -> Any:
        """Return the observation of all worlds, and keep the states and the maps."""
        action = self.played.state.action[:, 0].astype(np.float32)
        given = {**measured(self.played), "action": action, **self.states, **changed}
        if "pending" in self.names:
            sent = self.played.simulation.state.command[:, self.played.task.agents[0], : action.shape[1]]
            if self.played.simulation.model.drive[0] == OMNI_WORLD:
                turn = given["pose"][:, 2]
                sent = np.stack(
                    [
                        np.cos(turn) * sent[:, 0] + np.sin(turn) * sent[:, 1],
                        np.cos(turn) * sent[:, 1] - np.sin(turn) * sent[:, 0],
                    ],
                    axis=1,
                )
            if self.played.state.steps[0, 0] > 0:
                self.under_way = np.concatenate([self.under_way[:, 1:], sent[:, None]], axis=1)
            given["pending"] = self.under_way
        if self.maps:
            known = zip(self.maps, given["ranges"], given["pose"], given["goal"], strict=True)
            given["way_on_seen_map"] = np.stack([one.way(ranges, pose, goal) for one, ranges, pose, goal in known])
        outputs = self.session.run(None, {name: given[name] for name in self.names})
        found = dict(zip([one.name for one in self.session.get_outputs()], outputs, strict=True))
        self.states = {name: found[f"{name}_next"] for name in self.states}
        return found["seen"]


def differences(played: Episodes, n_steps: int, seed: int = 0) -> Iterator[float]:
    """Yield how far the twin is from the kernels at most, step by step of a random drive.

    A robot that is stuck is not compared where its motion is predicted: a graph does not know that it is.
    """
    twin, rng = Twin(played), np.random.default_rng(seed)
    yield float(np.abs(twin.see() - played.view.observation[:, 0]).max())
    for _ in range(n_steps):
        played.step(rng.uniform(-1.0, 1.0, (N_WORLDS, 1, int(played.action_sizes[0]))))
        moves = ~played.simulation.state.stopped[:, 0] | (not played.task.predict)
        yield float(np.abs(twin.see() - played.view.observation[:, 0])[moves].max())


def test_each_kind_that_a_robot_can_observe_by_itself_has_a_twin() -> None:
    families.load()
    own = [entry for entry in families.OBSERVATIONS if entry.kind.__module__.startswith("irsim_gym.")]
    alone = {entry.name for entry in own if set(entry.kind().needs) <= {"scan", "odometry", "map_frame", "grid"}}
    twins = {entry.name for entry in own if issubclass(entry.kind, HasGraph)}
    assert alone - twins == {"has_arrived", "seen_map_image"}
    assert {item if isinstance(item, str) else item["name"] for item in (*EVERYTHING, *FOLLOWED)} == twins


@pytest.mark.parametrize(
    ("robot", "observations", "shift", "others"),
    [
        (DIFF, EVERYTHING, 0.0, {}),
        (CAR, EVERYTHING, 1e5, {}),
        (OMNI, EVERYTHING, -1e5, {}),
        (DIFF, OTHERWISE, 0.0, {}),
        (DIFF, OTHERWISE, 0.0, MOVING),
        (OMNI, FOLLOWED, 0.0, MOVING),
    ],
    ids=["diff", "car far away", "omni far away", "other options", "others move", "tracks"],
)
def test_twins_equal_their_kernels(
    robot: dict[str, Any], observations: list[Any], shift: float, others: dict[str, Any]
) -> None:
    assert max(differences(episodes(robot, observations, shift, **others), 40)) < TOLERANCE


def test_the_twin_of_times_to_collision_equals_its_kernel_in_a_few_steps() -> None:
    """As above, in so little time that it is done in plain Python, too."""
    times = {"name": "time_to_collision", "directions": 7, "speeds": 2, "range": 2.5, "margin": 0.1}
    assert max(differences(episodes(DIFF, [times], **MOVING), 3)) < TOLERANCE


@pytest.mark.parametrize(
    ("robot", "seconds", "latency"),
    [(DIFF, 0.3, 0.3), (DIFF, 0.25, 0.3), (CAR, 0.4, 0.0), (CAR_BY_RATE, 0.2, 0.2), (OMNI, 0.5, 0.5)],
)
def test_a_predicted_task_observes_what_the_predictor_in_the_graph_does(
    robot: dict[str, Any], seconds: float, latency: float
) -> None:
    late = {**robot, "disturbances": [{"name": "latency", "time": latency}]}
    for observations in (EVERYTHING, OTHERWISE):
        assert max(differences(episodes(late, observations, predict=seconds, **MOVING), 40)) < TOLERANCE


def test_a_car_by_turn_rate_that_stands_is_not_predicted_to_turn() -> None:
    played = episodes(CAR_BY_RATE, ["heading"], predict=0.3)
    twin, heading = Twin(played), measured(played)["pose"][:, 2]
    for speed, turn in ((0.0, 0.0), (0.5, 0.3 * 0.6)):
        twin.under_way[:] = [speed, 0.6]
        then = heading + turn
        np.testing.assert_allclose(twin.see(), np.stack([np.cos(then), np.sin(then)], axis=1), atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_twins_equal_their_kernels_in_ten_thousand_observations(seed: int) -> None:
    kinds = [(DIFF, EVERYTHING, 1e5), (CAR, EVERYTHING, 0.0), (OMNI, EVERYTHING, 0.0), (DIFF, OTHERWISE, 0.0)]
    assert max(differences(episodes(*kinds[seed]), 2500 // N_WORLDS, seed)) < TOLERANCE


def test_broken_ranges_read_as_rep_117_says() -> None:
    played = episodes(DIFF, EVERYTHING)
    twin, same = Twin(played), Twin(played)
    raw = measured(played)["ranges"]
    raw[:, 3], raw[:, 10], raw[:, 20], raw[:, 30] = np.nan, np.inf, -np.inf, 99.0
    clean = raw.copy()
    clean[:, [3, 10, 30]], clean[:, 20] = SCANNER["range_max"], 0.0
    seen = twin.see(ranges=raw)
    assert np.isfinite(seen).all()
    np.testing.assert_array_equal(seen, same.see(ranges=clean))


def test_any_heading_will_do_where_the_goal_has_none() -> None:
    played = episodes(DIFF, ["goal_heading"])
    goal = measured(played)["goal"]
    goal[:, 2] = np.nan
    np.testing.assert_array_equal(Twin(played).see(goal=goal), np.zeros((N_WORLDS, 2)))
