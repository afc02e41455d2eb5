"""A recorded step is the plain step: the same bits, or not recorded at all."""

from __future__ import annotations

import copy
import pickle
import threading
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from numpy.typing import NDArray

import irsim_gym as ig
from irsim_gym.base.arraytypes import Ints
from irsim_gym.base.kernels import decorator as kernels
from irsim_gym.base.kernels import hooks, kernel, record, replay
from irsim_gym.base.kernels.packed import PackedEntries
from irsim_gym.bodies.drives.differential import Differential
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.errors import PlacementError
from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.engine import Shard, Simulation, compile
from irsim_gym.simulator.running.fused import Fused, only_kernels
from irsim_gym.simulator.world.state import State
from irsim_gym.tasks.terms.episode_state import EpisodeState

pytestmark = pytest.mark.skipif(not replay.is_possible(), reason="nothing is recorded where nothing is compiled")

SCENARIOS = sorted(file.stem for file in Path("configs/scenarios").glob("*.yaml"))
MINE = {
    "world": {"width": 10, "height": 10},
    "robot": [{"kinematics": {"name": "diff"}, "state": [2, 2, 0], "goal": [8, 8, 0], "behavior": {"name": "dash"}}],
}


def arrays(simulation: Simulation) -> dict[str, NDArray[Any]]:
    found = {name: getattr(simulation.state, name) for name in type(simulation.state).columns()}
    found |= {f"model {name}": getattr(simulation.model, name) for name in type(simulation.model).columns()}
    for g, group in enumerate(simulation.parts.sensors):
        found |= {f"sensor {g} {name}": values for name, values in group.arrays.items()}
    return found


def differing(one: dict[str, NDArray[Any]], other: dict[str, NDArray[Any]]) -> list[str]:
    assert set(one) == set(other)
    return [name for name in one if one[name].tobytes() != other[name].tobytes()]


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_scenario_is_recorded_and_stays_the_same(name: str) -> None:
    scenario = load_scenario(name)
    fused, plain = (compile(scenario, 3, fused=fused) for fused in (True, False))
    for simulation in (fused, plain):
        simulation.reset(5)
        for _ in range(15):
            simulation.step()
    assert differing(arrays(fused), arrays(plain)) == []
    assert fused._advance.programs[0] is not None
    assert plain._advance.programs == {}


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_task_is_recorded_and_stays_the_same(name: str) -> None:
    scenario = load_scenario(name)
    both = [Worlds(scenario, 3, team=True, num_threads=threads) for threads in (1, 2)]
    plain = both[1].episodes
    for one in (plain._begin, plain._play, plain._begin_episodes, plain.simulation._draw, plain.simulation._start):
        one.is_fusable = False
    numbers = np.random.default_rng(0)
    episodes = both[0].episodes
    for worlds in both:
        worlds.begin(range(3), [7, 8, 9], [{}] * 3, lambda w: 0)
    for _ in range(20):
        actions: NDArray[Any] = numbers.uniform(-1.0, 1.0, episodes._given.shape)
        if episodes.n_discrete:
            actions = numbers.integers(0, episodes.n_discrete, episodes._given.shape)
        for worlds in both:
            worlds.step(actions)
            view = worlds.episodes.view
            ended = np.flatnonzero((view.terminated | view.truncated).all(axis=1))
            if len(ended):
                worlds.begin_next(ended)
    found = [
        {name: getattr(worlds.episodes.state, name) for name in EpisodeState.columns()} | arrays(worlds.simulation)
        for worlds in both
    ]
    scratch = {name for name, values in found[0].items() if values.shape != found[1][name].shape}
    assert not scratch & {*EpisodeState.columns(), *State.columns()}, "a row for each thread"
    assert set(differing(*found)) <= scratch
    for one in (episodes._begin, episodes._play, episodes.simulation._draw):
        assert one.programs[0] is not None


def test_what_is_derived_has_to_promise_for_itself() -> None:
    class Mine(Differential):
        pass

    class Careful(Differential):
        only_kernels: ClassVar[bool] = True

    assert [only_kernels([kind]) for kind in (Differential, Mine, Careful, int)] == [True, False, True, False]


def test_some_worlds_alone() -> None:
    plain, fused = (compile(load_scenario(MINE), 5, fused=fused) for fused in (False, True))
    for simulation in (plain, fused):
        simulation.reset(0)
        simulation.run(simulation._advance, np.array([1, 4]))
        simulation.run(simulation._advance, np.array([4]))
    assert fused.state.step.tolist() == [0, 1, 0, 0, 2]
    assert differing(arrays(plain), arrays(fused)) == []


@pytest.mark.parametrize("chosen", [np.arange(6)[::2], np.array([4, 2, 0])[::-1], np.array([0, 2, 4], np.int32)])
def test_worlds_that_lie_apart_or_are_short_numbers(chosen: NDArray[Any]) -> None:
    simulation = compile(load_scenario(MINE), 6)
    simulation.reset(0)
    simulation.run(simulation._advance, chosen)
    assert simulation.state.step.tolist() == [1, 0, 1, 0, 1, 0]


def test_more_worlds_than_a_block() -> None:
    n = 2 * replay.BLOCK + 3
    plain, fused = (compile(load_scenario("wandering_crowd"), n, fused=fused) for fused in (False, True))
    for simulation in (plain, fused):
        simulation.reset(0)
        for _ in range(3):
            simulation.step()
    assert differing(arrays(plain), arrays(fused)) == []


def test_a_time_limit_that_changes_is_seen() -> None:
    env = ig.make("empty_goal")
    env.reset(seed=0)
    env.step(np.zeros(2, np.float32))
    env.unwrapped.worlds.limit(2)
    assert env.step(np.zeros(2, np.float32))[3]


def test_arrays_that_are_replaced_are_seen_by_tasks_too() -> None:
    worlds = Worlds(MINE)
    worlds.begin([0], [0], [{}], lambda w: 0)
    worlds.step(np.zeros((1, 1, 2)))
    simulation = worlds.simulation
    simulation.model.step_time = np.array([0.25])
    simulation.rewire()
    worlds.step(np.zeros((1, 1, 2)))
    assert simulation.state.time.tolist() == [0.5]


def test_goals_that_are_replaced_are_seen() -> None:
    world = ig.load(MINE)
    world.step()
    world.robot.set_goal([[5, 5, 0], [1, 1, 0], [2, 2, 0]])
    for _ in range(400):
        world.step()
    assert np.allclose(world.robot.state[:2], [2, 2], atol=0.3)


def test_copies_have_programs_of_their_own() -> None:
    first = compile(load_scenario(MINE))
    first.reset(0)
    first.step()
    before = first.state.pose.copy()
    for other in (copy.deepcopy(first), pickle.loads(pickle.dumps(first))):
        other.step()
        assert (first.state.pose == before).all()
        assert (other.state.pose != before).any()


@kernel
def add(worlds: NDArray[np.int64], amount: float, out: NDArray[np.float64]) -> None:
    """Add an amount in some worlds."""
    for i in range(worlds.shape[0]):
        out[worlds[i]] += amount


@kernel
def total(worlds: NDArray[np.int64], values: NDArray[np.float64]) -> float:
    """Sum up."""
    found = 0.0
    for i in range(worlds.shape[0]):
        found += values[worlds[i]]
    return found


@kernel
def mix(
    worlds: NDArray[np.int64],
    flag: bool,
    whole: int,
    large: np.uint64,
    amount: float,
    nothing: None,
    pair: tuple[NDArray[np.float64], float],
    nested: tuple[tuple[int, bool], NDArray[np.uint8]],
    records: Any,
    grid: NDArray[np.float32],
    out: NDArray[np.float64],
) -> None:
    """Write a number that every argument has a part in."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        known = 1.0 if nothing is None else 0.0
        small = np.float64(large >> np.uint64(60)) + nested[0][0] + (0.5 if nested[0][1] else 0.0) + nested[1][w]
        out[w] += (2.0 if flag else 0.0) + whole + amount + known + pair[0][w] * pair[1] + small
        out[w] += records[w].share + np.float64(grid[w, 1]) + grid.shape[1]


def test_arguments_of_every_type() -> None:
    out, pair = np.zeros(3), np.array([1.0, 2.0, 3.0])
    records = np.zeros(3, np.dtype((np.record, [("index", np.int64), ("share", np.float64)])))
    records["share"] = [0.125, 0.25, 0.375]
    grid = np.arange(12, dtype=np.float32).reshape(3, 4)[:, ::2]
    given = (True, -7, np.uint64(2**63 + 5), 0.5, None, (pair, 3.0), ((4, True), np.arange(3, dtype=np.uint8)))
    worlds = np.array([0, 2])
    calls = record(mix, worlds, *given, records, grid, out)
    assert not out.any()
    replay.Program(calls, worlds).run(worlds)
    # 2 - 7 + 0.5 + 1 + 3 x + (8 + 4 + 0.5 + w) + share + the grid's column 2 + its 2 columns
    expected = [2 - 7 + 0.5 + 1 + 3 * (w + 1) + 12.5 + w + 0.125 * (w + 1) + 4 * w + 2 + 2 for w in range(3)]
    assert out.tolist() == [expected[0], 0.0, expected[2]]


class InterruptedOnce:
    """A context variable; the user presses Ctrl-C just when it has been set."""

    def __init__(self) -> None:
        self.calls: Any = None
        self.is_quiet = False

    def get(self) -> Any:
        return self.calls

    def set(self, calls: Any) -> None:
        self.calls = calls
        if not self.is_quiet:
            self.is_quiet = True
            raise KeyboardInterrupt


def test_an_interrupt_leaves_kernels_alive(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernels, "_calls", InterruptedOnce())
    out = np.zeros(2)
    with pytest.raises(KeyboardInterrupt):
        record(add, np.arange(2), 1.0, out)
    add(np.arange(2), 1.0, out)
    assert out.tolist() == [1.0, 1.0]


def fused(function: Any) -> Fused:
    made = Fused(function)
    made(Shard(np.arange(2)))
    return made


def test_what_cannot_be_recorded_runs_as_it_is() -> None:
    out = np.zeros(2)
    made_anew = fused(lambda shard: (add(shard.worlds, 1.0, out), add(shard.worlds, 2.0, np.zeros(2))))
    gives_back = fused(lambda shard: (total(shard.worlds, out), add(shard.worlds, 1.0, out)))
    untold = fused(lambda shard: add(shard.worlds, np.float32(1.0), out))
    assert [one.programs for one in (made_anew, gives_back, untold)] == [{0: None}] * 3
    assert out.tolist() == [3.0, 3.0]


def test_a_number_that_changes_shows_when_it_is_recorded() -> None:
    out, amounts = np.zeros(2), iter([1.0, 2.0, 4.0])
    made = fused(lambda shard: add(shard.worlds, next(amounts), out))
    assert made.programs == {0: None}
    assert out.tolist() == [4.0, 4.0]


@kernel
def try_once(worlds: Ints, tries: Ints, needed: Ints, failed: Ints) -> None:
    """Fail until a world has had as many tries as it needs."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        tries[w] += 1
        failed[w] = 7 if tries[w] < needed[w] else 0


class Trials:
    """Tries worlds until they succeed, ten times at most, and notes those that are through with a second kernel."""

    def __init__(self, is_fusable: bool = True) -> None:
        self.needed = np.arange(2 * replay.BLOCK + 9) % 12
        self.tries, self.failed = np.zeros((2, len(self.needed)), np.int64)
        self.ended = np.zeros(len(self.needed))
        self.trial = Fused(lambda shard: try_once(shard.worlds, self.tries, self.needed, self.failed), is_fusable)
        self.fused = Fused(self.both)

    def both(self, shard: Shard) -> None:
        self.trial.repeat(shard, self.failed, 10)
        add(shard.worlds, 1.0, self.ended)


@pytest.mark.parametrize("is_fusable", [True, False])
@pytest.mark.parametrize("is_whole", [True, False])
def test_what_fails_is_repeated_alone(is_fusable: bool, is_whole: bool) -> None:
    """A part of a recorded function, or by itself; what is run as it is keeps the whole from being recorded."""
    made = Trials(is_fusable)
    worlds = np.arange(1, len(made.needed))
    (made.fused if is_whole else made.both)(Shard(worlds))
    assert made.tries.tolist() == [0, *np.clip(made.needed[1:], 1, 10)]
    assert made.failed.tolist() == [7 * (n == 11) for n in made.needed]
    assert made.ended.tolist() == [0.0] + [1.0] * len(worlds)
    assert [program is not None for program in made.fused.programs.values()] == [is_fusable] * is_whole


def test_recorded_functions_become_a_part_of_others() -> None:
    out = np.zeros(3)
    inner = Fused(lambda shard: add(shard.worlds, 1.0, out))
    outer = Fused(lambda shard: (inner(shard), add(shard.worlds, 2.0, out)))
    outer(Shard(np.array([0, 2])))
    assert out.tolist() == [3.0, 0.0, 3.0]
    program = outer.programs[0]
    assert program is not None
    assert program.n_calls == 2
    assert inner.programs == {}


@pytest.mark.parametrize("num_threads", [1, 2])
def test_a_level_that_cannot_be_drawn_is_told_and_others_go_on(num_threads: int) -> None:
    robot = {**MINE["robot"][0], "behavior": None, "distribution": {"name": "random", "min_distance": 0}}
    pillar = {"shape": {"name": "circle", "radius": 0.5}, "state": [5, 5]}
    worlds = Worlds({**MINE, "robot": [robot], "obstacle": [pillar]}, 6, num_threads=num_threads)
    worlds.begin(range(6), range(6), [{}] * 6, lambda w: 0)
    model = worlds.simulation.model
    model.local_discs[:, 1, 2] = model.reach[:, 1] = 20.0  # the pillar is everywhere
    with pytest.raises(PlacementError, match="no place found for 'robot_0'"):
        worlds.begin_next(np.array([1, 4]))
    model.local_discs[:, 1, 2] = model.reach[:, 1] = 0.5
    worlds.begin_next(np.array([1, 4]))
    assert (worlds.episodes.state.episode == [0, 2, 0, 0, 2, 0]).all()


def test_levels_that_need_several_draws_are_the_same() -> None:
    """Nine discs seldom find room where twelve would fit if they were put in order."""
    robot = {**MINE["robot"][0], "behavior": None, "state": [0.3, 0.3, 0], "goal": [3.7, 0.3, 0]}
    discs = {"number": 9, "shape": {"name": "circle", "radius": 0.5}}
    crowded = {"name": "random", "min_distance": 0}
    data = {"world": {"width": 4, "height": 4}, "robot": [robot], "obstacle": [{**discs, "distribution": crowded}]}
    whole, plain = (Worlds(data, 20) for _ in range(2))
    draws: list[int] = []
    draw = plain.simulation._draw
    draw.function = lambda shard, known=draw.function: (draws.append(len(shard.worlds)), known(shard))
    plain.episodes._begin.is_fusable = draw.is_fusable = False
    for worlds in (whole, plain):
        worlds.begin(range(20), range(20), [{}] * 20, lambda w: 0)
        worlds.begin_next(np.arange(0, 20, 3))
    assert draws.count(20) == 1
    assert len(draws) > 4
    assert differing(arrays(whole.simulation), arrays(plain.simulation)) == []
    assert whole.episodes.view.observation.tobytes() == plain.episodes.view.observation.tobytes()


def test_threads_are_handed_what_is_recorded_already(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[threading.Thread] = []
    record = Fused._record

    def noted(self: Fused, slot: int) -> replay.Program | None:
        seen.append(threading.current_thread())
        return record(self, slot)

    simulation = compile(load_scenario(MINE), 64, num_threads=3)
    simulation.reset(0)
    monkeypatch.setattr(Fused, "_record", noted)
    for _ in range(5):
        simulation.step()
    assert set(simulation._advance.programs) == {0, 1, 2}
    assert set(seen) == {threading.main_thread()}


def test_where_numba_packs_no_arguments_steps_go_on(monkeypatch: pytest.MonkeyPatch) -> None:
    def played() -> Worlds:
        worlds = Worlds("sparse_circles", 2)
        worlds.begin([0, 1], [3, 4], [{}] * 2, int)
        worlds.step(np.ones((2, 1, 2)))
        return worlds

    def fail(*_: object) -> int:
        raise AttributeError("no attribute '_engine'")

    usual = played()
    failures: list[str] = []
    monkeypatch.setattr(hooks, "_failures", lambda: failures)
    monkeypatch.setattr(PackedEntries, "address", fail)
    with pytest.warns(RuntimeWarning, match="failed with AttributeError: no attribute '_engine'") as seen:
        worlds = played()
    assert len(seen) == 1
    assert worlds.episodes._play.programs == {0: None}
    np.testing.assert_array_equal(worlds.episodes.view.observation, usual.episodes.view.observation)


def test_a_crowd_is_packed_without_looking_at_an_array_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    """Members of rvo decide one after the other: some kernels each, which share nearly all of their arrays."""
    looked = 0
    real = replay.typed

    def counted(*arguments: Any) -> Any:
        nonlocal looked
        looked += 1
        return real(*arguments)

    monkeypatch.setattr(replay, "typed", counted)
    counts = []
    for number in (10, 40):
        robots = {"number": number, "kinematics": {"name": "omni"}, "behavior": {"name": "rvo"}}
        sim = ig.compile(ig.load_scenario({"robot": {**robots, "distribution": {"name": "circle"}}}))
        sim.reset(seed=0)
        looked = 0
        sim.step()
        program = sim._advance.programs[0]
        assert program.n_calls > 3 * number
        counts.append(looked)
    assert counts[1] <= counts[0] + 30 * 8  # a few numbers for each further member, no arrays
