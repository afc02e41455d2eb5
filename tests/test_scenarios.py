"""The shipped scenarios are what their descriptions say."""

from __future__ import annotations

import numpy as np
import pytest

from irsim_gym.base.arraytypes import Floats
from irsim_gym.evaluation.comparison.evaluate import evaluate_policies
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.specs.library import scenario_names
from irsim_gym.simulator.engine import Simulation, compile
from irsim_gym.tasks import load_task

LEVELS = 64
ROOMS = {"cluttered_room": (8, 10), "dense_room": (16, 18)}


def drawn(name: str, n_worlds: int = LEVELS) -> Simulation:
    simulation = compile(load_scenario(name), n_worlds=n_worlds, agents=(0,))
    simulation.reset(seed=0)
    return simulation


def clearances(simulation: Simulation) -> Floats:
    distance = np.zeros((simulation.n_worlds, len(simulation.scenario.bodies)))
    everyone = np.arange(distance.shape[1])
    simulation.run(lambda shard: simulation.clearance(shard, everyone, distance))
    return np.where(simulation.model.present, distance, np.inf)


@pytest.mark.parametrize("name", scenario_names())
def test_levels_begin_free_and_differ(name: str) -> None:
    """Fixed walls may touch each other; whatever is placed touches nothing."""
    simulation = drawn(name)
    state, robot = simulation.state, 0
    placed = [b for b, body in enumerate(simulation.scenario.bodies) if body.kinematics or body.shape.is_random]
    assert not state.collided[:, placed].any()
    assert (clearances(simulation)[:, placed] > 0.0).all()
    is_random = simulation.scenario.placements[0].kind.is_random
    assert len(np.unique(state.pose[:, robot, 0])) == (LEVELS if is_random else 1)
    x0, y0, x1, y1 = simulation.model.bounds
    for points in (state.pose[:, robot], state.goal[:, robot]):
        assert ((points[:, 0] > x0) & (points[:, 0] < x1) & (points[:, 1] > y0) & (points[:, 1] < y1)).all()


@pytest.mark.parametrize(("name", "counts"), ROOMS.items())
def test_rooms_hold_as_many_obstacles_as_they_say(name: str, counts: tuple[int, int]) -> None:
    simulation = drawn(name)
    robot_and_walls = 2
    present = simulation.model.present.sum(axis=1) - robot_and_walls
    assert (present.min(), present.max()) == counts


@pytest.mark.parametrize("name", ROOMS)
def test_rooms_are_as_specified(name: str) -> None:
    scenario = load_scenario(name)
    robot, walls = scenario.bodies[0], scenario.bodies[1]
    (lidar,) = robot.sensors
    assert (scenario.world.width, scenario.world.height, scenario.world.step_time) == (10.0, 10.0, 0.1)
    assert (robot.shape.radius, robot.vel_min, robot.vel_max) == (0.2, (0.0, -1.5), (1.0, 1.5))
    assert (robot.goal_threshold, lidar.number, lidar.range_max) == (0.3, 180, 6.0)
    assert lidar.angle_range == pytest.approx(2.0 * np.pi)
    assert walls.shape.vertices == ((0, 0), (10, 0), (10, 10), (0, 10), (0, 0))
    assert scenario.task["max_steps"] == 300
    kinds = {type(body.shape).__name__ for body in scenario.bodies[2:]}
    assert len(kinds) == 3
    assert all(body.shape.is_random for body in scenario.bodies[2:])


@pytest.mark.parametrize("name", ROOMS)
def test_room_goals_are_far_away_and_walls_hold_everything(name: str) -> None:
    simulation = drawn(name)
    pose, present = simulation.state.pose, simulation.model.present
    assert (simulation.state.goal_distance[:, 0] >= 4.0).all()
    inside = (pose[..., :2] > 0.0) & (pose[..., :2] < 10.0)
    assert inside.all(axis=2)[:, 2:][present[:, 2:]].all()


def test_crossing_obstacles_keep_moving() -> None:
    """In every tenth of a long episode each of the six movers covers ground, in the room, around a resting robot."""
    simulation = drawn("crossing", n_worlds=8)
    movers = np.arange(2, 8)
    simulation.state.command[:] = 0.0
    for _ in range(10):
        path = np.zeros((8, len(movers)))
        before = simulation.state.pose[:, movers, :2].copy()
        for _ in range(60):
            simulation.step([0.0, 0.0])
            here = simulation.state.pose[:, movers, :2].copy()
            path += np.linalg.norm(here - before, axis=2)
            before = here
        stopped = simulation.state.stopped[:, movers]
        assert (path[~stopped] > 0.5).all()
        assert ((before > 0.0) & (before < 10.0)).all()


@pytest.mark.parametrize("n_robots", [4, 8, 16, 32])
def test_circle_swap_grows_with_its_robots(n_robots: int) -> None:
    """The circle stays 4 m up to 12 robots; then each has the arc of 2 pi / 3 m that it has with 12."""
    scenario = load_scenario("circle_swap", {"n_robots": n_robots})
    simulation = compile(scenario, 16, agents=scenario.robots)
    simulation.reset(seed=0)
    radius = max(4.0, n_robots / 3)
    center = np.array([scenario.world.width, scenario.world.height]) / 2
    assert len(scenario.robots) == n_robots
    assert center[0] - radius == pytest.approx(1.0)
    for points in (simulation.state.pose, simulation.state.goal):
        assert np.abs(np.linalg.norm(points[..., :2] - center, axis=-1) - radius).max() <= 0.4 + 1e-9
    assert simulation.state.goal_distance.min() >= 2 * radius - 0.8


SIDES = {
    "corridor_two_way": lambda start, goal: np.abs(goal[..., 0] - start[..., 0]) >= 8.0,
    "door_queue": lambda start, goal: (start[..., 0] < 5.0) != (goal[..., 0] < 5.0),
    "intersection": lambda start, goal: np.abs(goal - start).max(axis=-1) >= 6.0,
    "random_swap": lambda start, goal: np.linalg.norm(goal - start, axis=-1) >= 5.0,
    "mixed_team": lambda start, goal: np.linalg.norm(goal - start, axis=-1) >= 6.0,
}


@pytest.mark.parametrize("name", SIDES)
def test_everybody_of_a_team_has_to_pass_the_others(name: str) -> None:
    simulation = drawn(name, n_worlds=32)
    robots = list(simulation.scenario.robots)
    start, goal = (points[:, robots, :2] for points in (simulation.state.pose, simulation.state.goal))
    assert SIDES[name](start, goal).all()


@pytest.mark.parametrize("name", ["circle_swap", *SIDES])
def test_all_robots_of_a_team_may_learn_and_see_the_same(name: str) -> None:
    scenario = load_scenario(name)
    assert load_task(scenario).agents == (0,)
    assert load_task(scenario, team=True).agents == scenario.robots
    assert len(scenario.robots) >= 4
    (lidar,) = {body.sensors for body in scenario.bodies if body.role == "robot"}
    assert (lidar[0].number, lidar[0].range_max, lidar[0].angle_range) == (180, 6.0, pytest.approx(2 * np.pi))


@pytest.mark.parametrize(("name", "most"), [("push_box", 0.0), ("clear_doorway", 0.75), ("sort_boxes", 0.0)])
def test_pushing_has_to_be_learned(name: str, most: float) -> None:
    """Neither who drives straight at its goal nor who drives at random wins."""
    found = evaluate_policies(ScenarioRequest(name), ["dash", "random"], levels=64, references=False).summaries
    assert found[0].success.value <= most
    assert found[1].success.value <= 0.1


def test_a_boat_that_knows_the_floes_works_less_than_one_that_ignores_them() -> None:
    found = evaluate_policies(ScenarioRequest("ice_channel"), ["ice_channel", "dash"], levels=64, references=False)
    learned, straight = found.summaries
    assert learned.success.value == straight.success.value == 1.0
    assert learned.effort < 0.7 * straight.effort
