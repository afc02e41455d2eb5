"""Hybrid A*: ways over poses against shapely and hand-made cases, what bodies do on them, and whom it certifies."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely
import yaml
from numpy.typing import NDArray

import irsim_gym as ig
from irsim_gym.bodies.behaviors.hybrid_astar.moves import BACKWARD, FORWARD, MOST_MOVES, MOVE, SPARE, SPIN, lay_moves
from irsim_gym.bodies.behaviors.hybrid_astar.queue import PoseMemory, close_cell, is_closed, pop, push
from irsim_gym.bodies.behaviors.pursuit.motion import Moving
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.evaluation.levels import level_commands
from irsim_gym.evaluation.levels.certify import certify
from irsim_gym.evaluation.policies.behavior_policies import BehaviorPolicy
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.evaluation.protocol.teams import evaluate_team
from irsim_gym.evaluation.requests.episode_setup import make_episodes
from irsim_gym.scenario.specs.library import configs_folder
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL
from irsim_gym.simulator.world.outline import outline_rows, placed

Floats = NDArray[np.float64]
HYBRID = {"behavior": {"name": "hybrid_astar"}}
LONG = {"shape": {"name": "rectangle", "length": 0.9, "width": 0.4}, "goal_threshold": 0.2}
CAR: dict[str, Any] = {
    "kinematics": {"name": "acker", "mode": "steer"},
    "shape": {"name": "rectangle", "length": 0.9, "width": 0.5, "wheelbase": 0.5},
    "vel_min": [-0.8, -0.6], "vel_max": [1, 0.6], "acce": [1.5, 2.0], "goal_threshold": 0.3,
}  # fmt: skip


def begun(robot: dict[str, Any], *walls: list[list[float]], n_worlds: int = 1) -> Simulation:
    obstacles = [{"shape": {"name": "linestring", "vertices": vertices}} for vertices in walls]
    scenario = {"world": {"step_time": 0.1}, "robot": {**robot, **HYBRID}, "obstacle": obstacles}
    simulation = ig.compile(ig.load_scenario(scenario), n_worlds)
    simulation.reset(seed=0)
    return simulation


def run(simulation: Simulation, steps: int) -> int:
    """Step until the robot of the first world has arrived; return how many steps it took."""
    for step in range(steps):
        if simulation.state.arrived[0, 0]:
            return step
        simulation.step()
    return steps


def shipped(name: str, n_worlds: int) -> Simulation:
    """Return the first levels of a benchmark's split ``dev``, in which hybrid A* drives."""
    data = yaml.safe_load((configs_folder() / "benchmarks" / f"{name}.yaml").read_text(encoding="utf-8"))
    data["robot"][0] |= HYBRID
    simulation = ig.compile(ig.load_scenario(data), n_worlds)
    simulation.reset(0, "dev")
    return simulation


def way_of(simulation: Simulation, world: int = 0) -> Floats:
    """Return x, y, heading, ahead, turn and gear of each move."""
    tables = simulation.parts.behaviors[0].tables
    pieces = tables.pieces[world, 0, : tables.count[world, 0]]
    return np.stack([pieces[name] for name in ("x", "y", "heading", "ahead", "turn", "gear")], axis=1)


def poses_on(way: Floats, n: int) -> Floats:
    """Return n poses on each move, both ends included, by the formula of a circle, shape ``(n_moves, n, 3)``."""
    share = np.linspace(0.0, 1.0, n)
    x, y, heading, ahead, turn, _ = (column[:, None] for column in way.T)
    angle = heading + turn * share
    straight = np.abs(turn) < 1e-12
    radius = np.where(straight, 0.0, ahead / np.where(straight, 1.0, turn))
    dx = np.where(straight, share * ahead * np.cos(heading), radius * (np.sin(angle) - np.sin(heading)))
    dy = np.where(straight, share * ahead * np.sin(heading), radius * (np.cos(heading) - np.cos(angle)))
    return np.stack(np.broadcast_arrays(x + dx, y + dy, angle), axis=-1)


def standing(simulation: Simulation, world: int) -> Any:
    """Return all that stands, as shapely sees it."""
    model, parts = simulation.model, []
    for b in np.flatnonzero(model.present[world] & model.stands).tolist():
        segments, _ = outline_rows(model, simulation.state, world, b)
        points = np.vstack([segments[:, :2], segments[-1:, 2:]])
        parts.append(shapely.Polygon(points) if model.solid[b] else shapely.LineString(points))
    return shapely.union_all(parts)


def bodies_at(simulation: Simulation, poses: Floats) -> Any:
    """Return the robot's rectangle at poses ``(n, 3)``."""
    local = outline_rows(simulation.model, simulation.state, 0, 0, local=True)
    return np.array([shapely.Polygon(placed(*local, tuple(pose))[0][:, :2]) for pose in poses])


def moves_of(drive: int, low: list[float], high: list[float]) -> Any:
    still, moves = np.zeros(3), np.zeros(MOST_MOVES, MOVE)
    limits = np.array([*low, 0.0]), np.array([*high, 0.0]), np.full(3, np.inf)
    return moves[: lay_moves(Moving(drive, False, 0.5, 0.1, still, 0.0, still, *limits), 0.1, moves)]


def test_moves_stay_within_the_limits_of_a_car() -> None:
    moves = moves_of(ACKERMANN, [-0.8, -0.6], [1.0, 0.6])
    assert sorted(moves["gear"].tolist()) == [BACKWARD] * 5 + [FORWARD] * 5
    bend = moves["turn"] / moves["ahead"]
    assert np.abs(bend).max() == pytest.approx(np.tan(SPARE * 0.6) / 0.5)
    assert (np.sign(moves["ahead"]) == moves["gear"]).all()
    speed = np.where(moves["gear"] == FORWARD, 1.0, 0.8)
    assert moves["seconds"] == pytest.approx(np.abs(moves["ahead"]) / speed)


def test_moves_stay_within_the_limits_of_a_differential_drive() -> None:
    moves = moves_of(DIFFERENTIAL, [0.0, -1.0], [0.5, 1.5])
    assert set(moves["gear"].tolist()) == {FORWARD, SPIN, -SPIN}
    assert (np.abs(moves["ahead"]) <= 0.5 * moves["seconds"] + 1e-12).all()
    assert (moves["turn"] <= 1.5 * moves["seconds"] + 1e-12).all()
    assert (moves["turn"] >= -1.0 * moves["seconds"] - 1e-12).all()


def test_backward_arcs_turn_as_fast_as_the_body_does_to_that_side() -> None:
    """Driving back, an arc that bends to the right turns the body to the left."""
    moves = moves_of(DIFFERENTIAL, [-0.5, -1.0], [0.5, 1.5])
    for gear in (FORWARD, BACKWARD):
        arcs = moves[moves["gear"] == gear]
        rates = arcs["turn"] / arcs["seconds"]
        assert (rates.min(), rates.max()) == pytest.approx((-SPARE * 1.0, SPARE * 1.5))


@pytest.mark.parametrize("goal", [[20, 22], [18, 20]])
def test_a_car_without_a_reverse_gear_comes_round_to_a_goal_close_by(goal: list[float]) -> None:
    # Its smallest circle has the radius 0.7 / tan(0.9 * 0.2) = 3.8 m, so it has to go farther away from the goal first,
    # and beyond the table of costs without obstacles, which ends 5.3 m from the goal.
    car = CAR | {"shape": {"name": "rectangle", "length": 1.0, "width": 0.5, "wheelbase": 0.7}}
    car |= {"state": [20, 20, 0, 0], "goal": [*goal, 0], "vel_min": [0, -0.2], "vel_max": [1, 0.2]}
    scenario = {"world": {"step_time": 0.1, "width": 40, "height": 40}, "robot": car | HYBRID}
    simulation = ig.compile(ig.load_scenario(scenario))
    simulation.reset(seed=0)
    assert run(simulation, 400) < 400
    way = way_of(simulation)
    assert (way[:, 5] == FORWARD).all()
    assert np.abs(way[:, 4] / way[:, 3]).max() <= np.tan(SPARE * 0.2) / 0.7 + 1e-9


def test_the_queue_sorts_and_cells_are_found_again() -> None:
    generator = np.random.default_rng(0)
    memory = PoseMemory(*(part[0] for part in PoseMemory.reserve(1)))
    keys, size = generator.integers(0, 50, 200).astype(float), 0
    for node, key in enumerate(keys):
        size = push(memory, size, float(key), node)
    taken = []
    while size > 0:
        taken.append(keys[pop(memory, size)])
        size -= 1
    assert taken == sorted(keys)
    memory.closed[:] = -1
    cells = np.unique(generator.integers(0, 10**7, 2000))
    for cell in cells[::2].tolist():
        close_cell(memory.closed, cell)
    assert [is_closed(memory.closed, cell) for cell in cells.tolist()] == [k % 2 == 0 for k in range(len(cells))]


def test_a_free_way_is_straight() -> None:
    simulation = begun({**LONG, "kinematics": {"name": "diff"}, "state": [1, 5, 0], "goal": [6, 5, 0]})
    steps = run(simulation, 100)
    way = way_of(simulation)
    assert np.abs(way[:, [2, 4]]).max() == 0.0
    assert way[:, 1].tolist() == [5.0] * len(way)
    assert way[:, 3].sum() == pytest.approx(5.0, abs=0.6 * 0.2)
    assert steps == pytest.approx((5.0 - 0.2) / 0.1, abs=2)  # at 1 m/s, to within the threshold


@pytest.mark.parametrize("name", ["l_bend", "parking"])
def test_swept_poses_touch_nothing_and_bodies_arrive(name: str) -> None:
    simulation = shipped(name, 6)
    simulation.step()
    for world in range(6):
        way, walls = way_of(simulation, world), standing(simulation, world)
        poses = poses_on(way, 21)
        np.testing.assert_allclose(poses[:-1, -1], poses[1:, 0], atol=1e-9)
        assert shapely.distance(walls, bodies_at(simulation, poses.reshape(-1, 3))).min() > 0.005
    for _ in range(400):
        simulation.step()
    assert simulation.state.arrived[:, 0].all()
    assert not simulation.state.collided[:, 0].any()


def turned(point: list[float], turn: int, mirror: bool) -> list[float]:
    """Return a pose or place mirrored at y = 5 and turned about (5, 5) by quarters."""
    x, y, *heading = point
    if mirror:
        y, heading = 10.0 - y, [-angle for angle in heading]
    for _ in range(turn):
        x, y = 10.0 - y, x
    return [x, y, *(angle + turn * np.pi / 2 for angle in heading)]


DEAD_END = [[2.0, 4.2], [4.0, 4.2], [4.0, 5.8], [2.0, 5.8]]


@pytest.mark.parametrize(("turn", "mirror"), [(0, False), (1, False), (2, True), (3, True)])
def test_a_car_turns_around_in_a_dead_end(turn: int, mirror: bool) -> None:
    """It faces the end of a blind alley 1.6 m wide, and its half circle takes 1.5 m between the rear axles alone."""
    robot = {**CAR, "state": turned([3.0, 5.1, 0.0], turn, mirror), "goal": turned([1.0, 5.0, np.pi], turn, mirror)}
    simulation = begun({**robot, "arrive_mode": "state"}, [turned(list(point), turn, mirror) for point in DEAD_END])
    assert run(simulation, 400) < 400
    way = way_of(simulation)
    assert {FORWARD, BACKWARD} <= set(way[:, 5].tolist())
    dx, dy, angle = simulation.state.pose[0, 0] - simulation.state.goal[0, 0]
    angle = (angle + np.pi) % (2 * np.pi) - np.pi
    assert np.sqrt(dx * dx + dy * dy + angle * angle) < 0.3
    assert not simulation.state.collided[0, 0]


def test_it_waits_for_what_moves() -> None:
    corridor = [[[0.0, 4.5], [10.0, 4.5]], [[0.0, 5.5], [10.0, 5.5]]]
    robot = {**LONG, "kinematics": {"name": "diff"}, "state": [1.0, 5.0, 0.0], "goal": [9.0, 5.0], **HYBRID}
    other = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}, "state": [5.0, 5.0, 0.0]}
    walls = [{"shape": {"name": "linestring", "vertices": vertices}} for vertices in corridor]
    scenario = {
        "world": {"step_time": 0.1},
        "robot": robot,
        "obstacle": [*walls, {**other, "behavior": {"name": "dash"}}],
    }
    simulation = ig.compile(ig.load_scenario(scenario), 1)
    simulation.reset(seed=0)
    assert run(simulation, 100) == 100
    assert not simulation.state.collided[0].any()
    assert 3.5 < simulation.state.pose[0, 0, 0] < 4.4
    simulation.model.present[0, -1] = False
    assert run(simulation, 100) < 100


def test_no_way_no_command() -> None:
    robot = {**LONG, "kinematics": {"name": "diff"}, "state": [3.0, 5.0, 0.3], "goal": [8.0, 5.0]}
    box = [[2.0, 4.0], [4.0, 4.0], [4.0, 6.0], [2.0, 6.0], [2.0, 4.0]]
    simulation = begun(robot, box)
    run(simulation, 10)
    assert simulation.state.pose[0, 0].tolist() == [3.0, 5.0, 0.3]


@pytest.mark.parametrize("goal", [[5.0, 5.05], [5.0, 12.0]])
def test_no_search_for_a_goal_within_a_wall_or_outside_of_the_world(goal: list[float]) -> None:
    robot = {**LONG, "kinematics": {"name": "diff"}, "state": [3.0, 5.0, 0.3], "goal": goal}
    simulation = begun(robot, [[4.5, 5.0], [6.0, 5.0]])
    run(simulation, 3)
    assert simulation.state.pose[0, 0].tolist() == [3.0, 5.0, 0.3]
    assert not simulation.parts.behaviors[0].tables.memory.closed.any()  # a search begins by clearing its cells to -1


@pytest.mark.parametrize(("room", "longest"), [(60, 1.2), (1 << 19, 0.075)])
def test_cells_become_coarser_if_the_memory_is_full_and_finer_if_there_is_no_way(room: int, longest: float) -> None:
    """Moves lead two cells ahead, of 0.15 m at first; the poses in memory are those of the third search."""
    robot = {**LONG, "kinematics": {"name": "diff"}, "state": [3.0, 5.0, 0.3], "goal": [8.0, 5.0]}
    simulation = begun(robot, [[2.0, 4.0], [4.0, 4.0], [4.0, 6.0], [2.0, 6.0], [2.0, 4.0]])
    tables = simulation.parts.behaviors[0].tables
    tables.memory = tables.memory._replace(nodes=tables.memory.nodes[:, :room].copy())
    simulation.step()
    assert tables.cell[0] == pytest.approx(0.15)
    assert np.abs(tables.memory.nodes[0, 1:20]["ahead"]).max() == pytest.approx(longest)


DRIVES: dict[str, dict[str, Any]] = {
    "diff": {"vel_min": [-0.5, -1.0], "acce": [1.0, 2.0]},
    "acker by rate": {
        "kinematics": {"name": "acker", "mode": "angular", "wheelbase": 0.2},
        "vel_max": [1, 1.0],
        "vel_min": [-1, -1.0],
    },
}


@pytest.mark.parametrize("name", DRIVES)
def test_rectangles_of_every_drive_arrive_in_drawn_levels(name: str) -> None:
    scenario = yaml.safe_load((configs_folder() / "scenarios" / "cluttered_room.yaml").read_text(encoding="utf-8"))
    scenario["robot"][0] |= {"shape": {"name": "rectangle", "length": 0.5, "width": 0.3}, **DRIVES[name]}
    rows = evaluate(BehaviorPolicy("hybrid_astar"), Worlds(scenario, 12).episodes, 12, "dev")
    assert {row.outcome for row in rows} == {"success"}


def test_certificates_let_it_drive_bodies_that_are_no_discs() -> None:
    episodes = make_episodes("l_bend", n_worlds=3)
    policies = level_commands._fitting(episodes)
    assert "hybrid_astar" in policies
    rows = {name: evaluate_team(policies[name], episodes, 3, "test") for name in ("dash", "hybrid_astar")}
    made = certify(episodes, "test", 3, rows)
    assert made.reachable.all()
    assert made.outcome[1].tolist() == [[0], [0], [0]]
    assert (made.clearance <= 0.35 + 0.002).all()  # half of 1.1 m, less the inner radius of 0.2 m
    assert not certify(episodes, "test", 3, {"dash": rows["dash"]}).reachable.any()
    assert "hybrid_astar" not in level_commands._fitting(make_episodes("cluttered_room", n_worlds=1))
