"""Kinds from outside: the plugins that docs/plugins.md shows, as they stand there, and mistakes in others."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
import test_kinds
from contract_tools import assert_same
from gymnasium.vector import SyncVectorEnv

import irsim_gym
from irsim_gym import plugins
from irsim_gym.base import families
from irsim_gym.errors import IrsimGymError, KindError, ScenarioError
from irsim_gym.plugins import Outcome, kernel, kind, option
from irsim_gym.simulator.engine import Shard
from irsim_gym.tasks import Episodes, load_task

PAGE = (Path(__file__).parents[3] / "docs" / "plugins.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```python\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
FIVE = next(block for block in BLOCKS if block.startswith("# my_plugins.py"))
TWO = next(block for block in BLOCKS if "@irsim_gym.placement" in block)
DISC = {"shape": {"name": "circle", "radius": 0.2}}
ROBOT: dict[str, Any] = {
    **DISC,
    "kinematics": {"name": "tracks", "width": 0.4},
    "sensors": [{"name": "compass", "deviation": 0.1}],
    "goal": [8, 5],
}
SCENARIO: dict[str, Any] = {
    "world": {"name": "plugged"},
    "robot": {**ROBOT, "number": 2, "distribution": {"name": "column", "x": 2.0}},
    "obstacle": {**DISC, "kinematics": {"name": "tracks"}, "behavior": {"name": "rvo", "wander": True}},
}
TASK: dict[str, Any] = {
    "name": "blank",
    "action": {"name": "gentle", "share": 0.3},
    "observations": ["bearing", "velocity"],
    "rewards": ["progress", {"name": "jerk", "weight": 0.2}],
    "endings": ["arrived", {"name": "strayed", "radius": 0.9}],
    "max_steps": 12,
    "audit": False,
}


@pytest.fixture(autouse=True)
def _page(monkeypatch: pytest.MonkeyPatch) -> None:
    """Register what the page shows, for one test."""
    families.load()
    for family in families.every():
        monkeypatch.setattr(family, "_entries", dict(family._entries))
    for block in (FIVE, TWO.split("team =")[0]):
        exec(compile(block, "docs/plugins.md", "exec", dont_inherit=True), {"__name__": "my_plugins"})


def episodes(scenario: dict[str, Any], task: dict[str, Any], n_worlds: int = 2) -> Episodes:
    """Return episodes whose worlds have begun levels 0, 1, ..."""
    spec = irsim_gym.load_scenario(scenario)
    loaded = load_task(spec, task)
    played = Episodes(irsim_gym.compile(spec, n_worlds, agents=loaded.agents), loaded)
    played.begin(np.arange(n_worlds), np.arange(n_worlds))
    return played


def test_five_plugins_take_no_more_than_sixty_lines() -> None:
    assert len(FIVE.splitlines()) <= 60
    assert {f"@irsim_gym.{name}" for name in ("sensor", "observation", "reward", "ending", "drive")} == set(
        re.findall(r"^@irsim_gym\.\w+", FIVE, re.MULTILINE)
    )


@pytest.mark.parametrize("num_threads", [1, 2])
def test_a_batch_equals_single_environments(num_threads: int) -> None:
    """Also after autoresets, where memories are emptied."""
    native = irsim_gym.make_vec(SCENARIO, 3, task=TASK, autoreset_mode="SameStep", num_threads=num_threads)
    single = [lambda: irsim_gym.make(SCENARIO, task=TASK)] * 3
    sync, rng, ends = SyncVectorEnv(single, autoreset_mode="SameStep"), np.random.default_rng(0), 0
    assert_same(native.reset(seed=4), sync.reset(seed=4))
    for _ in range(40):
        actions = rng.uniform(-1, 1, native.action_space.shape).astype(np.float32)
        here, there = native.step(actions), sync.step(actions)
        assert_same(here, there)
        ends += int((here[2] | here[3]).sum())
    assert ends > 8


def test_teams_learn_with_them() -> None:
    batch = irsim_gym.make_batch(SCENARIO, 2, task=TASK, autoreset=False)
    team, rng = irsim_gym.parallel_env(SCENARIO, task=TASK), np.random.default_rng(1)
    batch.reset(seed=0)
    observations = team.reset(seed=1)[0]
    for _ in range(5):
        actions = rng.uniform(-1, 1, (2, 2, 2)).astype(np.float32)
        np.testing.assert_array_equal(np.stack(list(observations.values())), batch.observation()[1])
        observations = team.step(dict(zip(team.agents, actions[1], strict=True)))[0]
        batch.step(actions)


@pytest.mark.parametrize(
    ("family", "name"), [("kinematics", "tracks"), ("sensor", "compass"), ("distribution", "column")]
)
def test_they_keep_the_promises_of_their_families(family: str, name: str) -> None:
    test_kinds.test_single_batch_and_shards_agree_and_stay_finite(family, name)
    if family != "distribution":
        test_kinds.test_a_kind_writes_only_what_it_owns(family, name)


@pytest.mark.parametrize("key", ["dash", "rvo", "sfm", "group orca", "group sfm"])
def test_any_behaviour_for_omni_drives_it(key: str) -> None:
    """From (2, 5), which faces left, to (8, 5)."""
    behavior = {"group_behavior" if " " in key else "behavior": {"name": key.split()[-1]}}
    robot = {**ROBOT, **behavior, "state": [2, 5, np.pi / 2], "goal_threshold": 0.3}
    simulation = irsim_gym.compile(irsim_gym.load_scenario({"robot": robot}), 1)
    simulation.reset(seed=0)
    simulation.step()
    # A wanted velocity (1, 0) is 90 degrees to the right: tracks 0.4 and -0.4 m/s, a turn of -0.8 / 0.4 rad/s.
    if key == "dash":
        np.testing.assert_allclose(simulation.state.velocity[0, 0, :2], [0.4, -0.4], atol=1e-12)
        np.testing.assert_allclose(simulation.state.pose[0, 0], [2, 5, np.pi / 2 - 0.2], atol=1e-12)
    while not simulation.state.arrived[0, 0] and simulation.state.step[0] < 300:
        simulation.step()
    assert simulation.state.arrived[0, 0]


def test_a_drive_without_steer_is_refused() -> None:
    irsim_gym.drive("plain", command=("ahead", "turn"))(lambda ego, command: (command[0], 0.0, command[1]))
    with pytest.raises(ScenarioError, match="'dash' cannot drive kinematics 'plain'; it drives 'diff'"):
        irsim_gym.load_scenario({"robot": {"kinematics": {"name": "plain"}, "behavior": {"name": "dash"}}})


def test_a_placement_keeps_clear_of_others() -> None:
    """Both want the same place, and the second one is asked again."""

    @irsim_gym.placement("queue", gives_goal=True)
    def queue(ego: Any, others: Any) -> Any:
        return (2 + 0.5 * bool(others) * round(ego.uniform(0, 1)), 5, 0), (8, 5 + len(others), 0)

    robot = {**DISC, "kinematics": {"name": "diff"}, "number": 2, "distribution": {"name": "queue"}}
    simulation = irsim_gym.compile(irsim_gym.load_scenario({"robot": robot}), 8)
    simulation.reset(seed=0)
    np.testing.assert_array_equal(simulation.state.pose[:, :, 0], [[2.0, 2.5]] * 8)
    np.testing.assert_array_equal(simulation.state.goal[:, :, 1], [[5.0, 6.0]] * 8)


def test_memories_are_emptied_where_episodes_begin() -> None:
    """Calls are counted: of the sensor and the observation once at the start and once a step."""

    def count(ego: Any) -> int:
        ego.memory["n"] = ego.memory.get("n", 0) + 1
        return int(ego.memory["n"])

    irsim_gym.sensor("count")(lambda ego: count(ego))
    irsim_gym.observation("seen", size=2)(lambda ego: (ego.reading("count")[0] / 100, count(ego) / 100))
    irsim_gym.drive("moves", command=("v", "w"))(lambda ego, command: (0.01 * count(ego), 0.0, 0.0))
    robot = {**DISC, "kinematics": {"name": "moves"}, "sensors": [{"name": "count"}], "goal": [8, 5]}
    played = episodes({"robot": robot}, {"name": "blank", "observations": ["seen"], "endings": ["arrived"]})

    def seen() -> list[Any]:
        moves = np.rint(100 * played.simulation.state.twist[:, 0, 0])
        return [*np.rint(100 * played.view.observation[:, 0]).tolist(), moves.tolist()]

    for _ in range(2):
        played.step(np.zeros((2, 1, 2)))
    assert seen() == [[3, 3], [3, 3], [3, 3]]
    played.begin_next(np.array([1]))
    assert seen() == [[3, 3], [1, 1], [3, 1]]
    played.step(np.zeros((2, 1, 2)))
    played.respawn(np.array([[False], [True]]))
    assert seen()[1] == [1, 1]


OWN = {"role": "running", "outcome": Outcome.RUNNING, "needs_goal": False, "needs_ending": False}
MISSING = {
    "KINEMATICS": ["'command_names'", "'state_size'", "prepare(group, model, n_slots)", "begin(", "move("],
    "BEHAVIORS": ["'reads_neighbors'", "prepare(", "decide(group, model, state, shard)"],
    "GROUP_BEHAVIORS": ["'reads_neighbors'", "prepare(", "decide("],
    "FOOTPRINTS": ["'is_random'", "outline()"],
    "PLACEMENTS": ["'is_random'", "'roams'", "'ensures_way'", "'gives_goal'", "prepare(", "draw(", "failed)"],
    "MAPS": ["'is_random'", "outline()", "occupied(width, height, name, find)"],
    "DISTURBANCES": ["'acts_on'", "disturb(group, model, state, shard)"],
    "SHIELDS": ["prepare(group, response, model, n_slots)", "shield(group, model, state, shard)"],
    "SENSORS": ["'reading'", "group_key()", "prepare(group, outlines, model, n_slots)", "sense("],
    "ACTIONS": ["'n_choices'", "act("],
    "OBSERVATIONS": ["'needs_goal'", "'needs'", "write(", "'image_shape'"],
    "REWARDS": ["'role'", "'outcome'", "'needs_goal'", "'needs_ending'", "'weight'", "pay("],
    "ENDINGS": ["'outcome'", "'needs_goal'", "ends("],
}


@pytest.mark.parametrize("family", list(MISSING))
def test_each_missing_part_is_named(family: str) -> None:
    assert {name for name in dir(families) if isinstance(getattr(families, name), families.Registry)} == {
        *MISSING,
        "SECTIONS",
    }

    @kind
    class Mine:
        """Nothing is there."""

    with pytest.raises(KindError) as error:
        getattr(plugins, family).register("mine", Mine)
    assert [part for part in MISSING[family] if part not in str(error.value)] == []
    assert f"(test_each_missing_part_is_named.<locals>.Mine, {__file__}:" in str(error.value)


def test_parts_of_the_wrong_form_are_named() -> None:
    @kind
    class Mine:
        """A sensor."""

        reading = 3
        group_key = 4

        @staticmethod
        def prepare(group: Any, model: Any, n_slots: Any) -> None:
            """Lacks an argument."""

        @staticmethod
        def sense(group: Any, state: Any, model: Any, shard: Any) -> None:
            """Has another order."""

        def report(self) -> None:
            """Is optional, and lacks arguments."""

    with pytest.raises(KindError) as error:
        families.SENSORS.register("mine", Mine)
    for said in (
        "'reading' must be name of its reading in group.arrays, .*, got 3",
        r"'group_key' must be a method group_key\(\), got int",
        r"'prepare' is called as prepare\(group, outlines, model, n_slots\), but takes \(group",
        r"'sense' is called as .*: another order",
        r"'report' is called as report\(group, member, world\)",
    ):
        assert re.search(said, str(error.value)), said


def wrong_parameters() -> None:
    irsim_gym.reward("wrong")(lambda ego, others: 0.0)


def untyped_option() -> None:
    def wrong(ego, *, gain=1.0):
        return 0.0

    irsim_gym.sensor("wrong")(wrong)


def taken_option() -> None:
    def wrong(ego: Any, *, weight: float = 1.0) -> float:
        return 0.0

    irsim_gym.reward("wrong")(wrong)


def unknown_steer_option() -> None:
    def back(ego: Any, velocity: Any, *, width: float = 1.0) -> Any:
        return velocity

    irsim_gym.drive("wrong", command=("a", "b"), steer=back)(lambda ego, command: (0, 0, 0))


def one_number_of_command() -> None:
    irsim_gym.drive("wrong", command="ab")


def taken_name() -> None:
    irsim_gym.sensor("compass")(lambda ego: 0.0)


@pytest.mark.parametrize(
    ("make", "error", "said"),
    [
        (wrong_parameters, TypeError, r"reward 'wrong': the parameters must be ego, a '\*', and the options"),
        (untyped_option, TypeError, "sensor 'wrong': the option 'gain' needs a type, such as gain: float"),
        (taken_option, TypeError, "reward 'wrong': every reward has 'weight' already"),
        (unknown_steer_option, TypeError, "steer of kinematics 'wrong': the drive has no option 'width'"),
        (one_number_of_command, ValueError, "command must be two or three names, got 'ab'"),
        (taken_name, IrsimGymError, "sensor 'compass' is registered twice"),
    ],
)
def test_a_function_that_cannot_be_registered(make: Any, error: type[Exception], said: str) -> None:
    with pytest.raises(error, match=said):
        make()


def test_a_function_that_returns_anything_else() -> None:
    irsim_gym.sensor("wrong", size=2)(lambda ego: [1.0, 2.0, 3.0])
    simulation = irsim_gym.compile(irsim_gym.load_scenario({"robot": {**DISC, "sensors": [{"name": "wrong"}]}}), 1)
    with pytest.raises(KindError, match=r"sensor 'wrong' must return 2 numbers for 'robot_0', got \[1") as error:
        simulation.reset(seed=0)
    assert error.value.__notes__ == ["in sensor 'wrong' for 'robot_0', step 1 of world 0"]


@kernel
def fill(worlds: Any, column: int, amount: float, paid: Any) -> None:
    """Write a number into a column."""
    for i in range(worlds.shape[0]):
        for a in range(paid.shape[1]):
            paid[worlds[i], a, column] = amount


def pay_by_numpy(term: Any, model: Any, state: Any, episode: Any, shard: Shard) -> None:
    """Pay the same in each step, so that no comparison of numbers could show it."""
    episode.reward_term[shard.worlds, :, term.column] = -0.001


def pay_a_number(term: Any, model: Any, state: Any, episode: Any, shard: Shard) -> None:
    """Pay by a kernel, a number that changes."""
    fill(shard.worlds, term.column, -1e-4 * float(state.time[0]), episode.reward_term)


def pay_by_kernel(term: Any, model: Any, state: Any, episode: Any, shard: Shard) -> None:
    """Pay by a kernel, always the same."""
    fill(shard.worlds, term.column, -0.001, episode.reward_term)


@pytest.mark.parametrize(
    ("pay", "said"),
    [
        (pay_by_numpy, rf"Mine, .*, but {__file__}:\d+: assignment destination is read-only; steps take the plain"),
        (pay_a_number, "Mine, .*, but its kernels are called with other numbers or arrays from step to step"),
        (pay_by_kernel, ""),
    ],
)
def test_a_promise_that_is_not_kept_is_found(pay: Any, said: str) -> None:
    made = type(
        "Mine",
        (),
        {
            **OWN,
            "__module__": __name__,
            "__annotations__": {"weight": float, "only_kernels": ClassVar[bool]},
            "only_kernels": True,
            "weight": option(1.0, ge=0.0, meaning="Unused."),
            "pay": staticmethod(pay),
        },
    )
    families.REWARDS.register("mine", kind(made))
    robot = {**DISC, "kinematics": {"name": "diff"}, "state": [5, 5, 0], "goal": [9, 5]}
    task = {"name": "blank", "observations": ["goal"], "rewards": ["mine"], "endings": ["arrived"], "audit": False}

    def run(steps: int) -> tuple[Episodes, Any]:
        played, paid = episodes({"robot": robot}, task), []
        for _ in range(steps):
            played.step(np.full((2, 1, 2), 0.1))
            paid.append(played.view.reward.copy())
        return played, np.array(paid)

    if not said:
        played, paid = run(40)
        assert played._play.programs[0] is not None
    else:
        with pytest.warns(RuntimeWarning, match=said):
            played, paid = run(40)
        assert played._play.programs.get(0) is None
    expected = [-1e-4 * 0.1 * step for step in range(1, 41)] if pay is pay_a_number else [-0.001] * 40
    np.testing.assert_allclose(paid[:, :, 0], np.transpose([expected, expected]), atol=1e-12)


@kernel
def slide(worlds: Any, members: Any, step_time: Any, velocity: Any, pose: Any, twist: Any) -> None:
    """Move against the command."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for k in range(members.shape[0]):
            for axis in range(2):
                twist[w, members[k], axis] = -velocity[w, members[k], axis]
                pose[w, members[k], axis] += twist[w, members[k], axis] * step_time[0]


@kernel
def reverse(worlds: Any, members: Any, command: Any) -> None:
    """Turn velocities into commands."""
    for i in range(worlds.shape[0]):
        for k in range(members.shape[0]):
            for axis in range(2):
                command[worlds[i], members[k], axis] = -command[worlds[i], members[k], axis]


@kind
class Sledge:
    """A drive whose commands are velocities the other way round."""

    only_kernels: ClassVar[bool] = True
    command_names: ClassVar[tuple[str, ...]] = ("west", "south")
    state_size: ClassVar[int] = 3

    @staticmethod
    def prepare(group: Any, model: Any, n_slots: int) -> None:
        """Need no memory."""

    @staticmethod
    def begin(group: Any, model: Any, state: Any, shard: Shard) -> None:
        """Begin at rest."""

    @staticmethod
    def move(group: Any, model: Any, state: Any, shard: Shard) -> None:
        """Move."""
        slide(shard.worlds, group.members, model.step_time, state.velocity, state.pose, state.twist)

    @staticmethod
    def steer(group: Any, model: Any, state: Any, shard: Shard) -> None:
        """Steer."""
        reverse(shard.worlds, group.members, state.command)


def test_a_drive_with_kernels_is_steered_in_recorded_steps() -> None:
    """At 1 m/s from (2, 5) to (8, 5): after 30 steps of 0.1 s half of the way is done."""
    families.KINEMATICS.register("sledge", Sledge)
    robot = {**DISC, "kinematics": {"name": "sledge"}, "state": [2, 5, 0], "goal": [8, 5], "behavior": {"name": "dash"}}
    simulation = irsim_gym.compile(irsim_gym.load_scenario({"robot": robot}), 1)
    simulation.reset(seed=0)
    for _ in range(30):
        simulation.step()
    assert simulation._advance.programs[0] is not None
    np.testing.assert_allclose(simulation.state.pose[0, 0], [5, 5, 0], atol=1e-9)
    np.testing.assert_array_equal(simulation.state.velocity[0, 0], [-1, 0, 0])


def test_a_class_of_a_sensor_is_told_of_beginnings() -> None:
    @kind
    class Counter:
        """Counts its calls."""

        reading: ClassVar[str] = "calls"

        def group_key(self) -> tuple[Any, ...]:
            """Return what members have in common."""
            return ()

        @staticmethod
        def prepare(group: Any, outlines: Any, model: Any, n_slots: int) -> None:
            """Make room."""
            group.arrays["calls"] = np.zeros((len(model.present), len(group.members)))

        @staticmethod
        def begin(group: Any, shard: Shard) -> None:
            """Forget."""
            group.arrays["calls"][shard.worlds] = 0

        @staticmethod
        def sense(group: Any, model: Any, state: Any, shard: Shard) -> None:
            """Count."""
            group.arrays["calls"][shard.worlds] += 1

    families.SENSORS.register("counter", Counter)
    simulation = irsim_gym.compile(irsim_gym.load_scenario({"robot": {**DISC, "sensors": [{"name": "counter"}]}}), 2)
    for _ in range(2):
        simulation.reset(seed=0)
        simulation.step()
        np.testing.assert_array_equal(simulation.sensors[0].arrays["calls"], [[2], [2]])
