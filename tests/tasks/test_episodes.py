"""How episodes begin, go on and end, and what is written down about them."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from task_tools import BALL, ROBOT, drive, play, scenario

from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.engine import compile
from irsim_gym.tasks import Episodes, Outcome, load_task
from irsim_gym.tasks.episodes.account import decide_outcomes
from irsim_gym.tasks.terms.episode_state import EpisodeState
from irsim_gym.tasks.terms.outcome import PRECEDENCE


def test_success_at_the_hand_computed_step() -> None:
    # From x = 2 to 7.7 it is 5.7 m; nearer than 0.3 m for the first time at x = 7.8, after 58 steps of 0.1 m.
    episodes = play()
    for step in range(1, 59):
        assert not episodes.view.terminated[0, 0]
        drive(episodes, 1, 0)
        assert episodes.view.infos["steps"][0, 0] == step
    infos = {key: value[0, 0] for key, value in episodes.view.infos.items()}
    assert episodes.view.terminated[0, 0]
    assert not episodes.view.truncated[0, 0]
    assert infos["outcome"] == Outcome.SUCCESS
    assert infos["is_success"]
    assert infos["path_length"] == pytest.approx(5.8)
    assert infos["goal_distance"] == pytest.approx(0.2)
    assert infos["min_clearance"] == np.inf
    assert infos["hit"] == -1


def test_collision_names_the_body_hit() -> None:
    episodes = play(obstacle=[{**BALL, "state": [5, 8, 0]}, BALL])
    least = np.inf
    while not episodes.view.terminated[0, 0]:
        drive(episodes, 1, 0)
        least = min(least, abs(episodes.simulation.state.pose[0, 0, 0] - 5) - 0.7)
    infos = {key: value[0, 0] for key, value in episodes.view.infos.items()}
    assert infos["outcome"] == Outcome.COLLISION
    assert infos["hit"] == 2
    assert infos["min_clearance"] == 0.0
    assert least <= 1e-9
    assert not infos["is_success"]


def test_min_clearance_counts_the_start() -> None:
    episodes = play({"state": [4.2, 5, np.pi]}, BALL)
    for _ in range(5):
        drive(episodes, 1, 0)
    assert episodes.view.infos["min_clearance"][0, 0] == pytest.approx(0.1)


def test_leaving_the_world_by_more_than_the_footprint() -> None:
    episodes = play({"state": [10.05, 5, 0]})
    drive(episodes, 1, 0)
    assert episodes.view.infos["outcome"][0, 0] == Outcome.RUNNING  # x = 10.15, the disc still overlaps the world
    drive(episodes, 1, 0)
    assert episodes.view.infos["outcome"][0, 0] == Outcome.LEFT_WORLD
    assert episodes.view.terminated[0, 0]


def test_time_limit_truncates_exactly() -> None:
    episodes = play(task={"max_steps": 5})
    for step in range(1, 6):
        drive(episodes, -1, 1)
        assert bool(episodes.view.truncated[0, 0]) is (step == 5)
    assert not episodes.view.terminated[0, 0]
    assert episodes.view.infos["outcome"][0, 0] == Outcome.TIMEOUT


def test_an_end_in_the_last_step_is_no_truncation() -> None:
    episodes = play(task={"max_steps": 58})
    for _ in range(58):
        drive(episodes, 1, 0)
    assert episodes.view.terminated[0, 0]
    assert not episodes.view.truncated[0, 0]


@pytest.mark.parametrize("flags", range(16))
@pytest.mark.parametrize("late", [False, True])
def test_precedence(flags: int, late: bool) -> None:
    sizes = dict.fromkeys(("world", "agent", "reward", "feature", "extra"), 1)
    episode = EpisodeState.allocate({**sizes, "action": 2, "ending": 4})
    episode.ending[:], episode.steps[:] = [[[bool(flags >> k & 1) for k in range(4)]]], 10 if late else 9
    decide_outcomes(np.arange(1), np.array([int(item) for item in PRECEDENCE]), 10, episode)
    expected = Outcome.TIMEOUT if late else Outcome.RUNNING
    for item, applies in zip(reversed(PRECEDENCE), reversed(episode.ending[0, 0].tolist()), strict=True):
        expected = item if applies else expected
    assert episode.outcome[0, 0] == expected
    assert episode.terminated[0, 0] == (flags > 0)
    assert episode.truncated[0, 0] == (late and flags == 0)
    assert episode.success[0, 0] == (expected == Outcome.SUCCESS)
    assert [item.name for item in PRECEDENCE] == ["COLLISION", "LEFT_WORLD", "SUCCESS", "DEADLOCK"]


def test_an_ended_agent_stands_still_and_its_figures_stay() -> None:
    episodes = play({"state": [4.15, 5, 0]}, BALL, collision_mode="unobstructed")
    drive(episodes, 1, 0)
    drive(episodes, 1, 0)
    assert episodes.view.terminated[0, 0]
    pose = episodes.simulation.state.pose.copy()
    infos = {key: value.copy() for key, value in episodes.view.infos.items()}
    for _ in range(3):
        drive(episodes, 1, 1)
        assert episodes.view.reward[0, 0] == 0.0
    assert (episodes.simulation.state.pose == pose).all()
    assert all((episodes.view.infos[key] == value).all() for key, value in infos.items())
    assert episodes.view.terminated[0, 0]


def test_begin_clears_everything() -> None:
    episodes = play({"state": [4.25, 5, 0]}, BALL)
    first = episodes.view.observation.copy()
    drive(episodes, 1, 1)
    assert episodes.view.terminated[0, 0]
    drive(episodes, 1, 1)
    assert episodes.view.over[0, 0]
    episodes.begin(np.array([0]), np.array([0]))
    assert not episodes.view.over[0, 0]
    assert not episodes.state.began.any()
    assert (episodes.view.observation == first).all()
    assert not episodes.view.terminated[0, 0]
    assert episodes.view.reward[0, 0] == 0.0
    infos = {key: value[0, 0] for key, value in episodes.view.infos.items()}
    assert (infos["outcome"], infos["steps"], infos["hit"], infos["path_length"]) == (0, 0, -1, 0.0)
    assert infos["goal_distance"] == pytest.approx(3.75)
    assert infos["min_clearance"] == pytest.approx(0.05)
    episodes.begin(np.array([0]), np.array([7]))
    assert episodes.view.infos["level"][0, 0] == 7


@pytest.mark.parametrize(
    ("place", "is_outside"),
    [
        ([-0.15, 5], False), ([-0.25, 5], True), ([10.15, 5], False), ([10.25, 5], True),
        ([5, -0.15], False), ([5, -0.25], True), ([5, 10.15], False), ([5, 10.25], True),
    ],
)  # fmt: skip
def test_who_is_beyond_an_edge_by_more_than_a_radius_has_left_the_world(place: list[float], is_outside: bool) -> None:
    episodes = play()
    episodes.simulation.state.pose[0, 0, :2] = place
    episodes.simulation.place(np.array([0]))
    drive(episodes, -1, 0)  # stands still
    outcome = Outcome.LEFT_WORLD if is_outside else Outcome.RUNNING
    assert episodes.view.infos["outcome"][0, 0] == outcome


def test_stepping_some_worlds_leaves_the_others() -> None:
    episodes = play(n_worlds=3)
    before = episodes.view.observation.copy()
    episodes.step(np.ones((3, 1, 2)), np.array([1]))
    assert episodes.view.infos["steps"][:, 0].tolist() == [0, 1, 0]
    assert (episodes.view.observation[[0, 2]] == before[[0, 2]]).all()
    assert (episodes.view.observation[1] != before[1]).any()


def rollout(episodes: Episodes, worlds: slice, steps: int = 120) -> list[np.ndarray]:
    """Return all that learners get in some of 8 worlds, with restarts."""
    rng, seen = np.random.default_rng(5), []
    for _ in range(steps):
        actions = rng.uniform(-1, 1, (8, 1, 2))[worlds]
        actions[..., 0] = np.abs(actions[..., 0])
        episodes.step(actions)
        view = episodes.view
        infos = [value.astype(np.float64)[..., None] for value in view.infos.values()]
        flags = [view.terminated[..., None], view.truncated[..., None]]
        seen.append(np.concatenate([view.observation, view.reward[..., None], *flags, *infos], axis=2))
        ended = np.flatnonzero((view.terminated | view.truncated).all(axis=1))
        if len(ended):
            episodes.begin_next(ended)
    return seen


@pytest.mark.parametrize("name", ["cluttered_room", "crossing"])
def test_batch_sizes_and_threads_change_nothing(name: str) -> None:
    spec = load_scenario(name)
    task = load_task(spec, max_steps=40)
    made = [
        Episodes(compile(spec, n, agents=task.agents, num_threads=threads), task)
        for n, threads in ((8, 1), (8, 3), (1, 1))
    ]
    for episodes, levels in zip(made, (range(8), range(8), [3]), strict=True):
        episodes.begin(np.arange(len(levels)), np.array(levels))
    whole, sharded = (rollout(episodes, slice(None)) for episodes in made[:2])
    single = rollout(made[2], slice(3, 4))
    assert all((a == b).all() for a, b in zip(whole, sharded, strict=True))
    assert all((a[3] == b[0]).all() for a, b in zip(whole, single, strict=True))
    low, high = (np.concatenate([term[k] for term in made[0].observation_terms]) for k in (1, 2))
    observed = np.stack(whole)[..., : len(low)].astype(np.float32)
    assert ((observed >= low) & (observed <= high)).all()


def test_several_learners_end_one_by_one() -> None:
    robots = [{**ROBOT, "state": [7.5, 5, 0]}, {**ROBOT, "state": [2, 2, 0], "goal": [8, 2, 0]}]
    episodes = play(robots, task={"agents": "all"})
    assert episodes.n_agents == 2
    for _ in range(4):
        drive(episodes, 1, 0)
    assert episodes.view.terminated[0].tolist() == [True, False]
    assert episodes.view.infos["outcome"][0].tolist() == [Outcome.SUCCESS, Outcome.RUNNING]
    assert episodes.view.infos["steps"][0].tolist() == [3, 4]
    assert episodes.simulation.state.pose[0, :, 0] == pytest.approx([7.8, 2.4])


def test_others_keep_their_behaviour() -> None:
    robots = [ROBOT, {**ROBOT, "state": [2, 2, 0], "goal": [8, 2, 0], "behavior": {"name": "dash"}}]
    episodes = play(robots)
    for _ in range(10):
        drive(episodes, -1, 0)
    assert episodes.simulation.state.pose[0, :, 0] == pytest.approx([2.0, 3.0])


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda item: pickle.loads(pickle.dumps(item))])
def test_copies_go_on_by_themselves(duplicate: object) -> None:
    episodes = play(obstacle=BALL)
    drive(episodes, 1, 0.2)
    twin = duplicate(episodes)  # type: ignore[operator]
    for _ in range(5):
        drive(episodes, 1, 0.2)
        drive(twin, 1, 0.2)
    assert (twin.view.observation == episodes.view.observation).all()
    assert (twin.view.reward == episodes.view.reward).all()
    assert twin.view.infos["steps"] is twin.state.steps
    drive(twin, 1, -1)
    assert (twin.view.observation != episodes.view.observation).any()


def test_the_simulation_must_command_the_learners() -> None:
    spec = scenario()
    with pytest.raises(ValueError, match=r"the simulation's agents are \(\), the task \(0,\)"):
        Episodes(compile(spec), load_task(spec))
