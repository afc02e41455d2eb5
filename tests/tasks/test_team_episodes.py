"""Several agents in one world: whose episode ends when, what bodies do then, and what is shared."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from task_tools import BALL, ROBOT, drive, play, scenario

from irsim_gym.errors import ScenarioError
from irsim_gym.tasks import Episodes, Outcome, load_task
from irsim_gym.tasks.terms.outcome import HitKind

LANES = [{**ROBOT, "state": [2, y, 0], "goal": [8, y, 0]} for y in (2, 5, 8)]
OMNI = {**ROBOT, "kinematics": {"name": "omni_angular"}, "vel_min": [-1, -1, -1], "vel_max": [1, 1, 1]}


def team(robots: list[dict[str, Any]], obstacle: Any = None, n_worlds: int = 1, **task: Any) -> Episodes:
    return play(robots, obstacle, task, n_worlds, team=True)


def test_all_robots_learn_under_their_names_and_each_ends_by_itself() -> None:
    near = {**LANES[0], "goal": [2.95, 2, 0]}
    episodes = team([near, LANES[1], LANES[2]], {**BALL, "state": [5, 5, 0]}, max_steps=40)
    assert episodes.agent_names == ("robot_0", "robot_1", "robot_2")
    ends: dict[int, int] = {}
    for step in range(1, 41):
        drive(episodes, 1, 0)
        for a in np.flatnonzero(~episodes.view.live[0]):
            ends.setdefault(int(a), step)
    outcomes = episodes.view.infos["outcome"][0].tolist()
    assert outcomes == [Outcome.SUCCESS, Outcome.COLLISION, Outcome.TIMEOUT]
    assert ends == {0: 7, 1: 23, 2: 40}
    assert episodes.view.terminated[0].tolist() == [True, True, False]
    assert episodes.view.truncated[0].tolist() == [False, False, True]
    assert episodes.view.over[0].tolist() == [True, True, False]
    assert episodes.view.infos["hit_kind"][0].tolist() == [HitKind.NOTHING, HitKind.OBSTACLE, HitKind.NOTHING]


def test_the_kind_of_what_is_hit() -> None:
    head_on = [{**ROBOT, "state": [4, 2, 0]}, {**ROBOT, "state": [5, 2, np.pi]}]
    mover = {
        **BALL,
        "state": [5, 8, np.pi],
        "goal": [0, 8, 0],
        "kinematics": {"name": "diff"},
        "behavior": {"name": "dash"},
    }
    episodes = team([*head_on, {**ROBOT, "state": [4, 8, 0]}], mover)
    for _ in range(6):
        drive(episodes, 1, 0)
    assert episodes.view.infos["hit_kind"][0].tolist() == [HitKind.ROBOT, HitKind.ROBOT, HitKind.MOVING_OBSTACLE]


def test_collisions_cost_what_was_hit_and_end_what_they_are_said_to_end() -> None:
    robots = [{**ROBOT, "state": [4, 2, 0]}, {**ROBOT, "state": [5, 2, np.pi]}, {**ROBOT, "state": [4.2, 5, 0]}]
    rewards = [{"name": "collision", "weight": 9.0, "robot": 5.0, "obstacle": 7.0}]
    endings = [{"name": "collided", "bodies": ["obstacle"]}]
    episodes = team(robots, BALL, rewards=rewards, endings=endings)
    paid = np.zeros(3)
    for _ in range(6):
        drive(episodes, 1, 0)
        paid += episodes.view.reward_terms[0, :, episodes.reward_names.index("collision")]
    assert paid.tolist() == [-5.0, -5.0, -7.0]
    assert episodes.view.terminated[0].tolist() == [False, False, True]


@pytest.mark.parametrize(("ended", "passes"), [("stay", False), ("vanish", True)])
def test_what_the_body_of_an_ended_agent_does(ended: str, passes: bool) -> None:
    first = {**ROBOT, "state": [4, 5, 0], "goal": [4.5, 5, 0]}
    episodes = team([first, {**ROBOT, "state": [2, 5, 0]}], ended=ended, max_steps=80)
    for _ in range(80):
        drive(episodes, 1, 0)
    expected = Outcome.SUCCESS if passes else Outcome.COLLISION
    assert episodes.view.infos["outcome"][0].tolist() == [Outcome.SUCCESS, expected]
    assert bool(episodes.simulation.model.present[0, 0]) is not passes
    episodes.begin_next(np.arange(1))
    assert episodes.simulation.model.present[0, 0]


def test_the_share_of_the_team_in_each_reward_term() -> None:
    robots = [{**LANES[0], "state": [7.75, 2, 0]}, LANES[1]]
    penalties = [{"name": name, "weight": 9.0} for name in ("collision", "left_world")]
    own, half = (team(robots, team_reward=share, rewards=penalties) for share in (0.0, 0.5))
    for episodes in (own, half):
        drive(episodes, 1, 0)
    terms = own.view.reward_terms[0]
    mixed = 0.5 * terms + 0.5 * terms.mean(axis=0)
    assert own.view.terminated[0].tolist() == [True, False]
    np.testing.assert_allclose(half.view.reward_terms[0], mixed, rtol=1e-12)
    np.testing.assert_allclose(half.view.reward[0], mixed.sum(axis=1), rtol=1e-12)
    for episodes in (own, half):
        drive(episodes, 1, 0)
    alone = own.view.reward_terms[0, 1]
    np.testing.assert_allclose(half.view.reward_terms[0, 1], 0.75 * alone, rtol=1e-12)
    assert half.view.reward[0, 0] == 0.0


def test_a_share_that_makes_crashing_cheap_is_refused() -> None:
    with pytest.raises(ScenarioError) as caught:
        load_task(scenario(LANES[:2]), {"team_reward": 1.0}, team=True)
    problem, *others = caught.value.problems
    assert (len(others), problem.path) == (1, "team_reward")
    assert problem.message == (
        "an episode that ends as 'collided' costs 2 (collision 4, of which a share of 0.5 is the robot's own: "
        "team_reward 1, 2 learners), one that continues can cost 3 (time 2 + clearance 0.8 + smoothness 0.2): "
        "raise the former above 6, lower the latter or team_reward, or say 'audit: false'"
    )


def test_standing_still_away_from_the_goal_is_a_deadlock() -> None:
    robots = [LANES[0], LANES[1], {**LANES[2], "state": [7.75, 8, 0]}]
    endings = ["deadlocked"]
    rewards = [{"name": "deadlock", "weight": 3.5}]
    episodes = team(robots, deadlock_time=0.5, endings=endings, rewards=rewards)
    moves = np.array([[[0.0, 0.0], [-1.0, 0.0], [1.0, 0.0]]])
    for step in range(1, 6):
        episodes.step(moves if step > 1 else np.array([[[1.0, 0.0], [-1.0, 0.0], [1.0, 0.0]]]))
        if step == 1:
            assert episodes.view.infos["outcome"][0, 2] == Outcome.SUCCESS
    assert episodes.view.infos["outcome"][0].tolist() == [Outcome.RUNNING, Outcome.DEADLOCK, Outcome.SUCCESS]
    assert episodes.view.infos["stalled"][0].tolist() == pytest.approx([0.0, 0.5, 0.0])
    assert episodes.view.infos["deadlocked"][0].tolist() == [False, True, False]
    assert episodes.view.reward_terms[0, 1, episodes.reward_names.index("deadlock")] == -3.5


def test_drives_of_different_size_share_padded_rows() -> None:
    robots = [{**LANES[0]}, {**OMNI, "state": [2, 5, 0], "goal": [8, 5, 0]}]
    episodes = team(robots, observations=["velocity"])
    assert episodes.action_sizes.tolist() == [2, 3]
    names = [name for name, low, _ in episodes.observation_terms for _ in low]
    unused = [name for name, used in zip(names, episodes.feature_mask[0], strict=True) if not used]
    assert unused == ["last_action", "velocity"]
    assert episodes.feature_mask[1].all()
    episodes.step(np.array([[[1.0, 0.5, np.nan], [1.0, 0.0, 1.0]]]))
    pose = episodes.simulation.state.pose[0]
    np.testing.assert_allclose(pose[0], [2.1, 2.0, 0.075], atol=1e-12)
    assert pose[1, 2] == pytest.approx(0.1)
    assert (episodes.view.observation[0, 0][~episodes.feature_mask[0]] == 0.0).all()


def test_smoothness_counts_the_components_that_a_drive_has() -> None:
    # Each swings from end to end in all of its components: the largest change there is.
    robots = [LANES[0], {**OMNI, "state": [2, 5, 0], "goal": [8, 5, 0]}]
    episodes = team(robots, rewards=[{"name": "smoothness", "weight": 0.6}], max_steps=300)
    drive(episodes, 1, 1, 1)
    drive(episodes, -1, -1, -1)
    column = episodes.reward_names.index("smoothness")
    np.testing.assert_allclose(episodes.view.reward_terms[0, :, column], -0.6 / 300, rtol=1e-12)
    # One component of two, one of three.
    drive(episodes, 1, -1, -1)
    np.testing.assert_allclose(episodes.view.reward_terms[0, :, column], [-0.6 / 300 / 2, -0.6 / 300 / 3], rtol=1e-12)


def test_discrete_choices_of_different_drives() -> None:
    episodes = team([LANES[0], {**OMNI, "state": [2, 5, 0]}], action={"name": "discrete", "linear": 3, "angular": 3})
    episodes.step(np.array([[8, 8]]))
    action = episodes.state.action[0]
    assert action.tolist() == [[1.0, 1.0, 0.0], [1.0, 0.0, 1.0]]


SWAP = {**ROBOT, "number": 3, "distribution": {"name": "random", "min_goal_distance": 2.0}, "state": None, "goal": None}


def swap(**task: Any) -> Episodes:
    robots = [{key: value for key, value in SWAP.items() if value is not None}]
    return play(robots, BALL, task, n_worlds=4, team=True)


def test_an_agent_that_respawns_begins_anew_while_the_others_go_on() -> None:
    episodes = swap()
    for _ in range(10):
        drive(episodes, 0.2, 0.3)
    before, state = episodes.simulation.state.pose.copy(), episodes.state
    chosen = np.zeros((4, 3), np.bool_)
    chosen[1, 2] = chosen[3, 0] = True
    live_before = episodes.view.live.copy()
    episodes.respawn(chosen)
    pose = episodes.simulation.state.pose
    moved = (pose[:, :3] != before[:, :3]).any(axis=2)
    assert moved.tolist() == chosen.tolist()
    assert (state.steps[chosen] == 0).all()
    assert (state.path_length[chosen] == 0.0).all()
    assert (state.steps[~chosen & live_before] == 10).all()
    assert (state.clearance[chosen] > 0.0).all()
    gaps = np.linalg.norm(episodes.simulation.state.goal[:, :3, :2] - pose[:, :3, :2], axis=2)[chosen]
    assert (gaps >= 2.0).all()
    assert (np.abs(episodes.view.observation) <= 1.0).all()
    marks = episodes.observation_terms
    start = sum(len(low) for name, low, _ in marks[: [name for name, _, _ in marks].index("last_action")])
    assert episodes.view.observation[1, 2, start] == -1.0  # the action of rest
    assert not state.began.any()


def test_a_respawn_is_the_same_in_one_world_and_in_many() -> None:
    def run(n_worlds: int, threads: int) -> np.ndarray:
        robots = [{key: value for key, value in SWAP.items() if value is not None}]
        episodes = play(robots, BALL, {"max_steps": 30}, n_worlds, threads, team=True)
        seen = []
        for step in range(80):
            drive(episodes, 0.5, np.sin(0.1 * step))
            if not episodes.view.live.all():
                episodes.respawn(~episodes.view.live)
            assert episodes.view.live.all()
            seen.append(episodes.view.observation[0].copy())
        return np.array(seen)

    alone = run(1, 1)
    assert (alone == run(5, 1)).all()
    assert (alone == run(5, 2)).all()


def test_where_a_start_is_taken_any_free_place_will_do() -> None:
    blocker = {**LANES[0], "state": [5, 5, 0], "goal": [2, 5, 0]}
    episodes = team([{**LANES[1], "state": [2, 5, 0]}, blocker])
    for _ in range(20):
        episodes.step(np.array([[[1.0, 0.0], [-1.0, 0.0]]]))
    simulation = episodes.simulation
    simulation.state.pose[0, 1, :2] = [2.1, 5.0]
    simulation.place(np.array([1]))
    episodes.respawn(np.array([[True, False]]))
    gap = np.linalg.norm(simulation.state.pose[0, 0, :2] - [2.1, 5.0])
    assert gap > 0.4
    episodes.begin_next(np.arange(1))
    assert simulation.state.pose[0, 0].tolist() == [2.0, 5.0, 0.0]


def test_the_state_of_the_team_by_hand() -> None:
    episodes = team([{**LANES[0], "state": [7.75, 2, 0]}, LANES[1]], ended="vanish")
    drive(episodes, 1, 0)
    assert episodes.team_state()[0, 8:10].tolist() == [0.0, 1.0]  # ended, and seen where it did until the next step
    drive(episodes, 1, 0)
    states = episodes.team_state()
    assert states.shape == (1, episodes.team_state_size) == (1, 20)
    assert states.dtype == np.float32
    gone, live = states[0, :10], states[0, 10:]
    np.testing.assert_allclose(gone, [0, 0, 0, 0, 0, 0, 0.6, -0.6, 0, 0], atol=1e-6)
    np.testing.assert_allclose(live, [-0.56, 0.0, 1, 0, 1, 0, 0.6, 0.0, 1, 1], atol=1e-6)


def test_the_state_of_a_team_that_can_only_turn_has_no_speed() -> None:
    turning = {**LANES[0], "vel_min": [0, -1.5], "vel_max": [0, 1.5]}
    episodes = team([turning, LANES[1]])
    drive(episodes, 1, 1)
    states = episodes.team_state()
    assert states[0, 4:6].tolist() == [0.0, 0.0]
    assert states[0, 14] == np.float32(np.cos(0.15))  # the other one drives at its limit, in a bend


def test_neighbors_by_hand() -> None:
    robots = [
        {**LANES[0], "state": [2, 2, np.pi / 2]},
        {**LANES[1], "state": [2, 5, 0]},
        {**LANES[2], "state": [9, 9, 0]},
    ]
    neighbors = {"name": "neighbors", "count": 2, "range": 5.0, "speed": 2.0}
    episodes = team(
        robots,
        observations=[
            {"name": name, "use": False}
            for name in ("scan", "goal", "last_action", "free_travel", "goal_record", "trail")
        ]
        + [neighbors],
    )
    episodes.step(np.array([[[-1.0, 0.0], [1.0, 0.0], [-1.0, 0.0]]]))
    row = episodes.view.observation[0, 0]
    # robot_1 is 3 m ahead and 0.1 m to the right, and drives to the right at 1 m/s; robot_2 is out of range.
    np.testing.assert_allclose(row, [0.6, -0.02, 0.0, -0.5, 0.04, 1, 0, 0, 0, 0, 0, 0], atol=1e-6)


@pytest.mark.parametrize("name", ["neighbors", "nearest_bodies"])
def test_without_a_range_the_diagonal_of_the_world_is_the_unit(name: str) -> None:
    robots = [{**LANES[0], "state": [3, 7, 0]}, {**LANES[1], "state": [6, 7, 0]}]
    code = {"code": "linear"} if name == "nearest_bodies" else {}
    task = {"name": "blank", "observations": [{"name": name, "count": 1, **code}]}
    episodes = play(robots, None, task, team=True, width=6, height=8, offset=[1, 5])
    expected = [0.3, 0, 0, 0, 0.02, 1] if name == "neighbors" else [1, 0, 1 - (3 - 2 * 0.2) / 10, 0, 0]
    np.testing.assert_allclose(episodes.view.observation[0, 0], expected, atol=1e-6)


def test_a_neighbor_that_has_gone_leaves_zeros() -> None:
    neighbors = {"name": "neighbors", "count": 1, "range": 2.0}
    robots = [{**LANES[0], "state": [2, 2, 0]}, {**LANES[1], "state": [3.8, 2, 0]}]
    episodes = play(robots, None, {"name": "blank", "observations": [neighbors]}, team=True)
    assert episodes.view.observation[0, 0, 0] == pytest.approx(0.9)
    for _ in range(3):
        episodes.step(np.array([[[-1.0, 0.0], [1.0, 0.0]]]))
    assert episodes.view.observation[0, 0].tolist() == [0.0] * 6


def test_each_agent_is_told_its_own_drive() -> None:
    omni = {**LANES[0], "kinematics": {"name": "omni"}, "vel_min": [-1, -1], "vel_max": [1, 1]}
    robots = [{**LANES[0]}, {**OMNI, "state": [2, 5, 0]}, {**omni, "state": [2, 8, 0]}]
    episodes = play(robots, None, {"name": "blank", "observations": ["drive"]}, team=True)
    # In the order of names: diff, omni, omni_angular.
    assert episodes.view.observation[0].tolist() == [[1, 0, 0], [0, 0, 1], [0, 1, 0]]


def test_the_collision_that_ends_an_episode_is_paid_though_the_agent_was_touching_something_else() -> None:
    # At 0.1 m a step it overlaps the other robot in steps 2 to 9, and from step 10 on the ball.
    other, ball = {**ROBOT, "state": [2.55, 5, 0]}, {**BALL, "state": [3.65, 5, 0]}
    rewards = [{"name": "collision", "weight": 9.0, "robot": 0.0, "obstacle": 7.0}]
    task = {"rewards": rewards, "endings": [{"name": "collided", "bodies": ["obstacle"]}]}
    episodes = play([ROBOT, other], ball, task, team=True, collision_mode="unobstructed")
    kinds, paid = [], []
    while episodes.view.live[0, 0]:
        episodes.step(np.array([[[1.0, 0.0], [-1.0, 0.0]]]))
        kinds.append(int(episodes.view.infos["hit_kind"][0, 0]))
        paid.append(float(episodes.view.reward_terms[0, 0, episodes.reward_names.index("collision")]))
    assert kinds == [HitKind.NOTHING, *[HitKind.ROBOT] * 8, HitKind.OBSTACLE]
    assert episodes.view.infos["outcome"][0, 0] == Outcome.COLLISION
    assert paid == [0.0] * 9 + [-7.0]
