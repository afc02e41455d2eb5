"""What a behaviour sees of its body is what a script sees of it, under the same names."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.base import families
from irsim_gym.bodies.behaviors.python.views import BodyView, EgoView
from irsim_gym.errors import UnknownNameError
from irsim_gym.live.population.body import Body
from irsim_gym.simulator.readings.irsim_names import advice
from irsim_gym.simulator.readings.sensor_view import SensorView

ROBOT: dict[str, Any] = {
    "name": "me",
    "kinematics": {"name": "omni"},
    "shape": {"name": "rectangle", "length": 0.6, "width": 0.4},
    "state": [2, 2, 0.3],
    "velocity": [0.2, 0.1],
    "goal": [[6, 7], [8, 8, 1.0]],
    "vel_max": [2, 1.5],
    "acce": [3, 4],
    "color": "red",
    "fov": 1.5,
    "fov_radius": 6,
    "group": 4,
    "sensors": [{"name": "lidar2d", "number": 7, "range_max": 5, "offset": [0.1, 0, 0.2]}],
    "behavior": {"name": "own"},
}
OTHERS: list[dict[str, Any]] = [
    {"shape": {"name": "circle", "radius": 0.5}, "state": [4, 3, 0]},
    {"shape": {"name": "linestring", "vertices": [[0, 0], [1, 0], [1, 2]]}, "state": [1, 6, 0.5]},
    {"shape": {"name": "polygon", "vertices": [[0, 0], [1, 0], [0, 1]]}, "state": [7, 2, 0.5], "unobstructed": True},
]
OWN_OF_BEHAVIOURS = {"memory", "reading", "uniform", "normal"}
FLAT_ALIKE = ("velocity",)


@pytest.fixture(autouse=True)
def own_registries(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forget what a test registers."""
    families.load()
    monkeypatch.setattr(families.BEHAVIORS, "_entries", dict(families.BEHAVIORS._entries))


def public(cls: type[Any]) -> set[str]:
    return {name for name in dir(cls) if not name.startswith("_")}


def ask(question: Callable[[EgoView], Any], steps: int = 3, robot: dict[str, Any] = ROBOT) -> Any:
    """Return what a behaviour answers at its last call, and the world as a script sees it just before."""
    answers = []
    world: Any = None

    @ig.behavior("own")
    def own(ego: EgoView, others: list[BodyView]) -> Any:
        answers.append((question(ego), question(world[ego.name])))
        return [0.5, 0.25]

    world = ig.load({"robot": [robot], "obstacle": OTHERS})
    for _ in range(steps):
        world.step()
    return answers[-1]


def plain(value: Any) -> Any:
    """Return a value as plain data, bodies by their names."""
    if isinstance(value, (BodyView, Body)):
        return value.name
    if isinstance(value, SensorView):
        return value.options
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    return [plain(item) for item in value] if isinstance(value, list | tuple) else value


def test_each_name_of_one_side_is_on_the_other_or_says_what_to_use() -> None:
    views, scripts = public(EgoView), public(Body)
    assert views - scripts - OWN_OF_BEHAVIOURS == set()
    assert scripts - views - set(advice("body", "behavior")) == set()


SHARED = sorted((public(EgoView) & public(Body)) - set(FLAT_ALIKE) - {"fov_detect_object", "memory"})


def read(name: str) -> Callable[[Any], Any]:
    def question(body: Any) -> Any:
        value = getattr(body, name)
        return plain(value() if callable(value) else value)

    return question


def test_shared_names_tell_the_same() -> None:
    names = [name for name in SHARED if name != "spec"]
    assert len(names) > 60
    seen, told = ask(lambda body: {name: read(name)(body) for name in names})
    for name in names:
        if name == "contact":  # it holds arrays, so it equals itself alone
            assert repr(seen[name]) == repr(told[name])
        elif isinstance(told[name], (list, float, tuple)):
            np.testing.assert_allclose(_numbers(seen[name]), _numbers(told[name]), rtol=1e-12, err_msg=name)
        else:
            np.testing.assert_equal(seen[name], told[name], err_msg=name)


def _numbers(value: Any) -> Any:
    return value if np.asarray(value).dtype.kind in "fi" else np.zeros(0)


def test_a_reading_is_the_latest_one() -> None:
    """A disc of radius 0.5 lies 2 m ahead of the sensor in the middle beam, and comes nearer as the robot drives."""
    seen = []

    @ig.behavior("own")
    def own(ego: EgoView, others: list[BodyView]) -> Any:
        seen.append((ego.scan()["ranges"][1], ego.get_lidar_points()))
        return [1.0, 0.0]

    lidar = {"name": "lidar2d", "number": 3, "angle_range": 1.0, "range_max": 5}
    robot = {**ROBOT, "state": [1, 3, 0], "velocity": [0, 0], "acce": [100, 100], "sensors": [lidar]}
    sim = ig.compile(ig.load_scenario({"robot": [robot], "obstacle": [OTHERS[0]]}), 2)
    sim.reset(seed=0)
    for _ in range(2):
        sim.step()
    assert [row[0] for row in seen] == pytest.approx([2.5, 2.5, 2.4, 2.4], abs=1e-5)
    points = seen[0][1]
    assert points is not None
    assert points[:, 0] == pytest.approx([2.5, 0.0], abs=1e-5)


def test_what_is_worked_out_by_hand() -> None:
    def question(body: Any) -> Any:
        return body.goal_vertices, body.get_vel_range(), body.max_speed, body.get_desired_omni_vel(), body.rvo_state

    world_free = []

    @ig.behavior("own")
    def own(ego: EgoView, others: list[BodyView]) -> Any:
        world_free.append((question(ego), ego.hit, ego.goals, others[0].rvo_neighbor_state, ego.rvo_neighbors))
        return [0.0, 0.0]

    sim = ig.compile(ig.load_scenario({"robot": [{**ROBOT, "goal": [2, 6, np.pi / 2]}], "obstacle": OTHERS[:1]}))
    sim.reset(seed=0)
    sim.step()
    (corners, limits, speed, desired, rvo), hit, goals, neighbor, neighbors = world_free[0]
    assert sorted(map(tuple, np.round(corners, 9))) == [(1.8, 5.7), (1.8, 6.3), (2.2, 5.7), (2.2, 6.3)]
    assert limits[0] == pytest.approx([-0.1, -0.3])
    assert limits[1] == pytest.approx([0.5, 0.5])
    assert speed == pytest.approx(2.5)
    assert desired == pytest.approx([0.0, 1.5])
    assert rvo[:2] == [2.0, 2.0]
    assert rvo[4:] == pytest.approx([0.1 + np.hypot(0.3, 0.2), 0.0, 1.5, 0.3])
    assert (hit, goals.tolist()) == (None, [[2, 6, np.pi / 2]])
    assert neighbor == pytest.approx([4, 3, 0, 0, 0.6])
    assert neighbors == [neighbor]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("set_goal", "it returns the command of its own"),
        ("trajectory", r"ego\.memory"),
        ("velocty", r"did you mean 'velocity'\?"),
        ("qqqq", "a body in a behaviour has no 'qqqq'\nin behavior"),
    ],
)
def test_a_name_that_is_nowhere_says_what_to_use(name: str, said: str) -> None:
    with pytest.raises(AttributeError, match=said):
        ask(lambda body: getattr(body, name), steps=1)


@pytest.mark.parametrize(("name", "said"), [("memory", "a script has variables"), ("uniform", "NumPy's generators")])
def test_what_only_behaviours_have(name: str, said: str) -> None:
    world = ig.load({"robot": [{**ROBOT, "behavior": {"name": "dash"}}]})
    with pytest.raises(AttributeError, match=said):
        getattr(world.robot, name)


@pytest.mark.parametrize(
    ("name", "said"),
    [("scan", "'me' has no range sensor number 0"), ("detected", "'me' has no field of view: give it fov")],
)
def test_sensors_and_fields_of_view_that_are_not_there(name: str, said: str) -> None:
    bare = {key: value for key, value in ROBOT.items() if key not in ("sensors", "fov", "fov_radius")}
    with pytest.raises(UnknownNameError, match=said):
        ask(read(name), steps=1, robot=bare)


def test_an_omni_angular_robot_counts_its_speed_to_the_side() -> None:
    """As in IR-SIM: the greatest speed over ground is the length of the first two limits, 0.3 and 0.4 m/s."""
    robot = {"kinematics": {"name": "omni_angular"}, "vel_max": [0.3, 0.4, 1], "state": [1, 1, 0], "goal": [1, 5]}
    body = ig.load({"robot": robot}).robot
    assert body.max_speed == pytest.approx(0.5)
    assert body.desired_omni_vel == pytest.approx([0.0, 0.4])
