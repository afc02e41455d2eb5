"""Behaviours written in plain Python."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.base import families
from irsim_gym.bodies.behaviors.python.views import BodyView, EgoView
from irsim_gym.errors import BehaviorError, IrsimGymError, ScenarioError, UnknownNameError

DISC = {"name": "circle", "radius": 0.2}
OMNI: dict[str, Any] = {"kinematics": {"name": "omni"}, "shape": DISC}


@pytest.fixture(autouse=True)
def own_registries(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forget what a test registers."""
    families.load()
    for registry in (families.BEHAVIORS, families.GROUP_BEHAVIORS):
        monkeypatch.setattr(registry, "_entries", dict(registry._entries))


def simulation(
    robots: Any, n_worlds: int = 1, obstacle: Any = None, num_threads: int = 1, **world: Any
) -> ig.Simulation:
    data = {"world": world, "robot": robots, **({"obstacle": obstacle} if obstacle else {})}
    sim = ig.compile(ig.load_scenario(data), n_worlds, num_threads=num_threads)
    sim.reset(seed=3)
    return sim


def register(function: Callable[..., Any], name: str = "own", **options: Any) -> None:
    ig.behavior(name, **options)(function)


def test_a_function_drives_with_its_options() -> None:
    @ig.behavior("towards", kinematics=("omni",))
    def towards(
        ego: EgoView, others: list[BodyView], *, gain: float = 1.0, pace: Literal["slow", "fast"] = "slow"
    ) -> Any:
        """Drive at the goal."""
        assert ego.goal is not None
        return gain * (2.0 if pace == "fast" else 1.0) * (ego.goal - ego.pose)[:2]

    robot = {**OMNI, "state": [1, 1], "goal": [2, 1.5]}
    sim = simulation(
        [
            {**robot, "behavior": {"name": "towards", "gain": 0.5}},
            {**robot, "state": [1, 5], "behavior": {"name": "towards", "gain": 0.25, "pace": "fast"}},
        ]
    )
    sim.step()
    assert sim.state.velocity[0, 0] == pytest.approx([0.5, 0.25, 0])
    assert sim.state.velocity[0, 1] == pytest.approx([0.5, -1, 0])  # limited to -1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ({"gian": 1.0}, "gian: unknown key (did you mean 'gain'?)"),
        ({"gain": "much"}, "gain: must be a number, got 'much'"),
        ({"range_low": [9, 9, 9], "range_high": [1, 1, 1]}, "range_low: must not exceed range_high"),
    ],
)
def test_options_are_checked(text: dict[str, Any], message: str) -> None:
    def own(ego: EgoView, others: list[BodyView], *, gain: float = 1.0) -> Any:
        return [gain, 0.0]

    register(own)
    with pytest.raises(ScenarioError) as caught:
        simulation({**OMNI, "behavior": {"name": "own", **text}})
    assert message in str(caught.value)


def test_drives_that_it_cannot_command_are_refused() -> None:
    register(lambda ego, others: [0.0, 0.0], kinematics=("omni",))
    with pytest.raises(ScenarioError, match="'own' cannot drive kinematics 'diff'; it drives 'omni'"):
        simulation({"kinematics": {"name": "diff"}, "behavior": {"name": "own"}})
    with pytest.raises(UnknownNameError, match="did you mean 'omni'"):
        ig.behavior("other", kinematics=("omny",))


def test_each_world_of_a_batch_shows_its_own_bodies() -> None:
    seen = []

    def own(ego: EgoView, others: list[BodyView]) -> Any:
        seen.append((ego.radius, [other.radius for other in others], ego.velocity_max.tolist()))
        return [0.0, 0.0]

    register(own)
    robot = {**OMNI, "shape": {"name": "circle", "radius": 0.3}, "vel_max": [2, 1], "behavior": {"name": "own"}}
    data = {"robot": robot, "obstacle": {"shape": {"name": "circle", "radius": 0.5}, "state": [8, 8]}}
    sim = ig.compile(ig.load_scenario(data), n_worlds=3)
    sim.reset(seed=0)
    sim.step()
    assert [(round(r, 12), others, most[:2]) for r, others, most in seen] == [(0.3, [0.5], [2.0, 1.0])] * 3


@pytest.mark.parametrize(
    "answer", [None, [1.0], [1.0, 2.0, 3.0], [np.nan, 0.0], [np.inf, 0.0], "fast", [[1.0], [2.0], [3.0]], {}]
)
def test_an_answer_that_is_no_command_names_the_behaviour(answer: Any) -> None:
    register(lambda ego, others: answer)
    sim = simulation({**OMNI, "behavior": {"name": "own"}})
    with pytest.raises(BehaviorError, match=r"behavior 'own' must return 2 finite numbers for 'robot_0', got "):
        sim.step()


def test_a_column_is_a_command_too() -> None:
    register(lambda ego, others: np.array([[0.3], [0.4]]))
    sim = simulation({**OMNI, "behavior": {"name": "own"}})
    sim.step()
    assert sim.state.velocity[0, 0].tolist() == [0.3, 0.4, 0.0]


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda ego: 0, "the parameters must be ego, others, a"),
        (lambda ego, others, gain: 0, "the parameters must be ego, others, a"),
        (lambda ego, others, *more: 0, "the parameters must be ego, others, a"),
        (lambda ego, others, *, gain: 0, "the option 'gain' needs a type"),
        (lambda ego, others, *, wander: 0, "every behavior has 'wander' already"),
    ],
)
def test_parameters_are_checked(function: Any, message: str) -> None:
    with pytest.raises(TypeError, match=message):
        register(function)


def test_a_name_is_taken_once() -> None:
    with pytest.raises(IrsimGymError, match="behavior 'dash' is registered twice"):
        register(lambda ego, others: 0, "dash")


def test_what_the_views_tell() -> None:
    seen: list[tuple[EgoView, list[BodyView]]] = []

    def own(ego: EgoView, others: list[BodyView]) -> Any:
        seen.append((ego, others))
        return [0.0, 0.0]

    register(own)
    robot = {**OMNI, "name": "me", "state": [1, 2, 0.5], "velocity": [0.1, 0.2], "behavior": {"name": "own"}}
    box = {"shape": {"name": "rectangle", "length": 3, "width": 4, "wheelbase": 1}, "state": [5, 5, np.pi / 2]}
    ghost = {"shape": DISC, "state": [8, 8, 0], "unobstructed": True}
    sim = simulation({**robot, "vel_max": [0.7, 0.8], "goal": [3, 3]}, obstacle=[box, ghost])
    sim.step()
    ego, others = seen[0]
    assert (ego.name, ego.role, ego.id, ego.radius, ego.time, ego.step_time) == ("me", "robot", 0, 0.2, 0.1, 0.1)
    assert ego.velocity_max.tolist() == [0.7, 0.8, 0]
    assert ego.goal is not None
    assert ego.goal[:2].tolist() == [3, 3]
    assert ego.discs.tolist() == [[*ego.pose[:2], 0.2]]
    assert [other.name for other in others] == ["obstacle_1", "obstacle_2"]
    assert [other.is_unobstructed for other in (ego, *others)] == [False, False, True]
    wall = others[0]
    assert (wall.role, wall.goal, wall.is_movable, wall.radius) == ("obstacle", None, False, 2.5)
    assert wall.center == pytest.approx([5, 5.5])
    assert wall.segments.shape == (4, 4)
    assert wall.segments[:, 1].min() == pytest.approx(4)
    wall.pose[:] = 9
    assert wall.pose.tolist() == [5, 5, np.pi / 2]


@pytest.mark.parametrize(("update", "expected"), [("sequential", 1.1), ("simultaneous", 1.0)])
def test_later_bodies_see_earlier_ones_already_moved(update: str, expected: float) -> None:
    places = []

    def own(ego: EgoView, others: list[BodyView]) -> Any:
        if ego.id == 1:
            places.append(others[0].pose[0])
        return [1.0, 0.0]

    register(own)
    robots = [{**OMNI, "state": [1, y], "behavior": {"name": "own"}} for y in (1, 3)]
    simulation(robots, update=update).step()
    assert places == [pytest.approx(expected)]


def test_target_roles_choose_what_is_seen() -> None:
    seen = {}

    def own(ego: EgoView, others: list[BodyView]) -> Any:
        seen[ego.id] = [other.name for other in others]
        return [0.0, 0.0]

    register(own)
    roles = ("all", "robot", "obstacle")
    robots = [
        {**OMNI, "state": [2 * i + 1, 1], "behavior": {"name": "own", "target_roles": role}}
        for i, role in enumerate(roles)
    ]
    simulation(robots, obstacle={"shape": DISC, "state": [5, 5]}).step()
    assert seen == {0: ["robot_1", "robot_2", "obstacle_3"], 1: ["robot_0", "robot_2"], 2: ["obstacle_3"]}


def test_memory_and_random_numbers_are_the_worlds_own() -> None:
    def own(ego: EgoView, others: list[BodyView], *, spread: float = 0.3) -> Any:
        ego.memory["count"] = ego.memory.get("count", 0) + 1
        return [ego.normal(0.0, spread), 0.1 * ego.memory["count"] + 0.01 * ego.uniform(0.0, 1.0)]

    register(own)
    robots = [{**OMNI, "state": [1, y], "behavior": {"name": "own"}} for y in (1, 3)]
    batch, sharded, single = simulation(robots, 4), simulation(robots, 4, num_threads=3), simulation(robots)
    single.reset(seed=3 + 2)
    first = []
    for sim in (batch, sharded, single):
        for _ in range(4):
            sim.step()
        first.append(sim.state.pose.copy())
    np.testing.assert_array_equal(first[0], first[1])
    np.testing.assert_array_equal(first[0][2], first[2][0])
    assert len(set(first[0][:, 0, 0])) == 4
    batch.reset(seed=3)
    for _ in range(4):
        batch.step()
    np.testing.assert_array_equal(batch.state.pose, first[0])


@pytest.mark.parametrize("again", ["reset", "reset_to_start"])
@pytest.mark.parametrize("register_one", ["behavior", "group_behavior"])
def test_memory_is_empty_in_a_new_episode_that_begins_by_hand(register_one: str, again: str) -> None:
    counts = []

    def own(ego: Any, others: list[BodyView]) -> Any:
        for one in ego if isinstance(ego, list) else [ego]:
            one.memory["count"] = one.memory.get("count", 0) + 1
            counts.append(one.memory["count"])
        return [[0.0, 0.0]] if isinstance(ego, list) else [0.0, 0.0]

    getattr(ig, register_one)("own")(own)
    sim = simulation({**OMNI, "state": [1, 1], register_one: {"name": "own"}})
    sim.step()
    sim.step()
    getattr(sim, again)()
    sim.step([[0.0, 0.0]], bodies=np.array([0]))
    sim.step()
    assert counts == ([1, 2, 1] if register_one == "behavior" else [1, 2, 1, 2])


def test_wander_and_loop_are_the_simulators() -> None:
    def own(ego: EgoView, others: list[BodyView]) -> Any:
        assert ego.goal is not None
        return 5 * (ego.goal - ego.pose)[:2]

    register(own)
    wander = {"name": "own", "wander": True, "range_low": [4, 4, 0], "range_high": [6, 6, 0]}
    sim = simulation({**OMNI, "state": [1, 1], "behavior": wander})
    goals = {tuple(sim.state.goal[0, 0]) for _ in range(150) if sim.step() is None}
    assert len(goals) >= 3


def test_a_group_decides_together() -> None:
    calls = []

    @ig.group_behavior("rally", kinematics=("omni",))
    def rally(members: list[EgoView], others: list[BodyView], *, gain: float = 1.0) -> Any:
        calls.append(([member.name for member in members], [other.name for other in others]))
        middle = np.mean([member.pose[:2] for member in members], axis=0)
        return [gain * (middle - member.pose[:2]) for member in members]

    entry = {**OMNI, "number": 2, "state": [[1, 1], [3, 1]], "group_behavior": {"name": "rally", "gain": 0.5}}
    still = {**OMNI, "state": [2, 4], "group": 0, "static": True}
    sim = simulation([entry, still, {**OMNI, "state": [8, 8]}], obstacle={"shape": DISC, "state": [5, 9]})
    sim.step()
    assert calls == [(["robot_0", "robot_1", "robot_2"], ["robot_3", "obstacle_4"])]
    assert sim.state.velocity[0, :3].tolist() == [[0.5, 0.5, 0], [-0.5, 0.5, 0], [0, 0, 0]]


@pytest.mark.parametrize(("answer", "found"), [(None, "no list"), ([[0, 0]], "1 commands"), (3.0, "no list")])
def test_a_group_gets_one_command_each(answer: Any, found: str) -> None:
    ig.group_behavior("rally")(lambda members, others: answer)
    sim = simulation({**OMNI, "number": 2, "state": [[1, 1], [3, 1]], "group_behavior": {"name": "rally"}})
    with pytest.raises(BehaviorError, match=f"group behavior 'rally' must return 2 commands.*got {found}"):
        sim.step()


def test_a_wrong_command_of_a_group_names_its_member() -> None:
    ig.group_behavior("rally")(lambda members, others: [[0.0, 0.0], [0.0]])
    sim = simulation({**OMNI, "number": 2, "state": [[1, 1], [3, 1]], "group_behavior": {"name": "rally"}})
    with pytest.raises(BehaviorError, match="'rally' must return 2 finite numbers for 'robot_1'"):
        sim.step()


def test_an_error_of_the_function_tells_behaviour_body_and_step() -> None:
    def own(ego: EgoView, others: list[BodyView]) -> Any:
        ego.memory["calls"] = ego.memory.get("calls", 0) + 1
        return [0.0, 0.0] if ego.id == 0 or ego.memory["calls"] < 3 else [1.0 / 0.0, 0.0]

    register(own)
    sim = simulation({**OMNI, "number": 2, "state": [[1, 1], [1, 3]], "behavior": {"name": "own"}}, n_worlds=2)
    sim.step()
    sim.step()
    with pytest.raises(ZeroDivisionError) as caught:
        sim.step()
    assert caught.value.__notes__ == ["in behavior 'own' for 'robot_1', step 3 of world 0"]
    assert caught.traceback[-1].name == "own"


def test_an_error_of_a_group_tells_behaviour_and_step() -> None:
    @ig.group_behavior("own")
    def own(members: list[EgoView], others: list[BodyView]) -> Any:
        raise KeyError("lost")

    sim = simulation({**OMNI, "number": 2, "state": [[1, 1], [1, 3]], "group_behavior": {"name": "own"}})
    with pytest.raises(KeyError, match="lost") as caught:
        sim.step()
    assert caught.value.__notes__ == ["in group behavior 'own' for the group of 'robot_0', step 1 of world 0"]


@pytest.mark.parametrize("key", ["behavior", "group_behavior"])
def test_an_unknown_behaviour_tells_how_to_register_one(key: str) -> None:
    with pytest.raises(ScenarioError, match=rf"registered by @irsim_gym\.{key}, on the command line from --import"):
        simulation({**OMNI, key: {"name": "mine"}})
