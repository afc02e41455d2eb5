"""Reading tasks: what they mean, who learns, and how mistakes are told."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from task_tools import BALL, ROBOT, play, scenario

from irsim_gym.base.families import ENDINGS, REWARDS
from irsim_gym.errors import ScenarioError, UnknownNameError
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.specs import library
from irsim_gym.tasks import load_task
from irsim_gym.tasks.terms.outcome import PRECEDENCE

TIMED = {"name": "time", "weight": 2.0}


def names(items: tuple[Any, ...]) -> list[str]:
    return [type(item).__name__ for item in items]


def messages(spec: Any, task: Any = None) -> list[str]:
    with pytest.raises(ScenarioError) as caught:
        load_task(spec, task)
    return [f"{problem.path}: {problem.message}" for problem in caught.value.problems]


# --- defaults


def test_a_plain_file_gets_navigation() -> None:
    task = load_task(scenario())
    assert task.name == "navigation"
    assert task.agents == (0,)
    assert task.max_steps == 300
    assert names(task.observations) == ["Scan", "Goal", "LastAction", "FreeTravel", "GoalRecord", "Trail"]
    assert {REWARDS.name_of(type(reward)): reward.weight for reward in task.rewards} == {
        "progress": 4.0,
        "arrival": 5.0,
        "collision": 4.0,
        "left_world": 4.0,
        "time": 2.0,
        "clearance": 0.8,
        "smoothness": 0.2,
    }
    assert names(task.endings) == ["Arrived", "Collided", "LeftWorld"]
    assert task.observation_form == "flat"


@pytest.mark.parametrize("name", library.scenario_names())
def test_shipped_scenarios_have_a_task(name: str) -> None:
    task = load_task(load_scenario(name))
    assert task.max_steps >= 1
    assert names(task.observations)[0] in ("Scan", "NearestBodies", "MovableBodies")


def test_the_audit_holds_for_every_registered_kind() -> None:
    for entry in REWARDS:
        assert entry.kind.role in ("potential", "bonus", "penalty", "running")
        assert (entry.kind.role in ("bonus", "penalty")) == (entry.kind.outcome in PRECEDENCE)
        with pytest.raises(ValueError, match="greater than or equal to 0"):
            entry.kind(weight=-1.0)
    assert all(entry.kind.outcome in PRECEDENCE for entry in ENDINGS)


# --- overriding


def test_sections_override_the_file_they_name() -> None:
    section = {
        "name": "navigation",
        "max_steps": 77,
        "observation_form": "dict",
        "action": {"name": "discrete", "angular": 7},
        "observations": ["velocity", {"name": "last_action", "use": False}, {"name": "scan", "sectors": 12}],
        "rewards": [{"name": "time", "weight": 1.0}],
        "endings": [{"name": "left_world", "use": False}],
    }
    section["rewards"].append({"name": "left_world", "use": False})  # type: ignore[attr-defined]
    for task in (load_task(scenario(task=section)), load_task(scenario(), section)):
        assert task.max_steps == 77
        assert task.observation_form == "dict"
        assert task.action.n_choices == 21
        assert names(task.observations) == ["Scan", "Goal", "FreeTravel", "GoalRecord", "Trail", "Velocity"]
        assert (task.observations[0].sectors, task.observations[0].zero) == (12, 0.3)
        assert [reward.weight for reward in task.rewards] == [4.0, 5.0, 4.0, 1.0, 0.8, 0.2]
        assert names(task.endings) == ["Arrived", "Collided"]


def test_max_steps_of_the_caller_wins() -> None:
    assert load_task(scenario(task={"max_steps": 50}), max_steps=7).max_steps == 7
    for bad in (0, -1, 2.5, True):
        with pytest.raises(ValueError, match="max_steps must be a whole number >= 1"):
            load_task(scenario(), max_steps=bad)  # type: ignore[arg-type]


def test_another_action_begins_from_its_own_defaults() -> None:
    first = {"name": "blank", "observations": ["goal"], "action": {"name": "discrete", "linear": 4}}
    assert load_task(scenario(task=first)).action.n_choices == 20
    assert load_task(scenario(task={**first, "action": "velocity"})).action.n_choices == 0


def test_files_build_upon_files(tmp_path: Path) -> None:
    (tmp_path / "slow.yaml").write_text("name: navigation\nmax_steps: 900\n")
    (tmp_path / "slower.yaml").write_text("name: slow.yaml\nrewards: [{name: time, weight: 0.5}]\n")
    (tmp_path / "bare.yaml").write_text("observations: [goal]\n")
    task = load_task(scenario(), tmp_path / "slower.yaml")
    assert task.name == "slower"
    assert task.max_steps == 900
    assert task.rewards[4].weight == 0.5
    bare = load_task(scenario(), str(tmp_path / "bare.yaml"))
    assert (names(bare.observations), bare.rewards, bare.endings, bare.max_steps) == (["Goal"], (), (), 500)
    (tmp_path / "world.yaml").write_text("robot: {kinematics: {name: diff}, goal: [8, 5]}\ntask: {name: slow.yaml}\n")
    assert load_task(load_scenario(tmp_path / "world.yaml")).max_steps == 900
    (tmp_path / "loop_a.yaml").write_text("name: loop_b.yaml\n")
    (tmp_path / "loop_b.yaml").write_text("name: loop_a.yaml\n")
    with pytest.raises(ScenarioError, match="extend each other"):
        load_task(scenario(), tmp_path / "loop_a.yaml")


def test_the_time_limit_of_a_scenario_holds_for_other_tasks_that_state_none(tmp_path: Path) -> None:
    (tmp_path / "own.yaml").write_text("name: navigation\nobservations: [velocity]\n")
    (tmp_path / "slow.yaml").write_text("name: navigation\nmax_steps: 900\n")
    world = scenario(task={"name": "navigation", "max_steps": 123})
    assert load_task(world, tmp_path / "own.yaml").max_steps == 123
    assert load_task(world, "image_navigation").max_steps == 123
    assert load_task(world, tmp_path / "slow.yaml").max_steps == 900
    assert load_task(scenario(), tmp_path / "own.yaml").max_steps == 300
    with pytest.raises(ScenarioError, match=r"task.max_steps: must be >= 1, got 0"):
        load_task(scenario(task={"max_steps": 0}), tmp_path / "own.yaml")


# --- who learns

TWO = [{**ROBOT, "name": "ann"}, {**ROBOT, "name": "bob", "state": [2, 2, 0]}]


@pytest.mark.parametrize(
    ("given", "team", "agents"),
    [
        (None, False, (0,)),
        (None, True, (0, 1)),
        ("bob", False, (1,)),
        (["bob", "ann"], False, (1, 0)),
        ("all", False, (0, 1)),
    ],
)
def test_who_learns(given: Any, team: bool, agents: tuple[int, ...]) -> None:
    section = {} if given is None else {"agents": given}
    assert load_task(scenario(TWO, task=section), team=team).agents == agents


def test_who_cannot_learn() -> None:
    assert messages(scenario(TWO, BALL, {"agents": "bib"})) == [
        "task.agents: no robot named 'bib' (did you mean 'bob'?); the robots: ann, bob"
    ]
    many = {**ROBOT, "number": 12, "group_name": "walkers", "distribution": {"name": "circle", "radius": 4}}
    first = ", ".join(f"robot_{i}" for i in range(10))
    assert messages(scenario(many, task={"agents": ["x"]})) == [
        f"task.agents[0]: no robot named 'x'; the robots: {first} and 2 others"
    ]
    assert messages(scenario(many, task={"agents": "walkers"})) == [
        f"task.agents: 'walkers' is a group: name its robots, {first} and 2 others"
    ]
    assert messages(scenario(TWO, {**BALL, "name": "ball"}, {"agents": ["ann", "ball"]})) == [
        "task.agents[1]: 'ball' is an obstacle; only robots can learn"
    ]
    assert messages(scenario(TWO, task={"agents": ["ann", "ann"]})) == ["task.agents[1]: 'ann' is named twice"]
    assert messages(load_scenario({"obstacle": BALL})) == ["robot: there is no robot that can learn"]
    static = {"kinematics": None, "shape": {"name": "circle"}, "goal": [8, 5]}
    assert any("it never moves" in text for text in messages(load_scenario({"robot": static})))


def test_a_learner_without_a_goal_is_refused_unless_nothing_needs_one() -> None:
    spec = scenario({"goal": None})
    assert messages(spec) == [
        "robot_0: has no goal, and the task 'navigation' needs one "
        "(for 'goal', 'goal_record', 'progress', 'arrival', 'arrived'): add a goal, or take a task without, such as "
        "{name: blank, observations: [velocity]}; task: {agents: NAME} lets another robot learn, "
        "and irsim_gym.load runs a file without learning"
    ]
    assert load_task(spec, {"name": "blank", "observations": ["velocity"]}).rewards == ()


def test_a_distribution_gives_goals() -> None:
    assert load_task(scenario({"goal": None, "distribution": {"name": "random"}})).agents == (0,)


def test_without_a_range_sensor_navigation_observes_bodies() -> None:
    episodes = play({"sensors": None}, BALL)
    shown = ["nearest_bodies", "goal", "last_action", "exact_free_travel", "route", "goal_record", "trail"]
    assert [name for name, _, _ in episodes.observation_terms] == shown
    both = {"observations": ["nearest_bodies", "route"]}
    found = names(load_task(scenario({"sensors": None}), both).observations)
    assert found == ["Goal", "LastAction", "ExactFreeTravel", "GoalRecord", "Trail", "NearestBodies", "Route"]
    assert messages(scenario({"sensors": None}), {"name": "blank", "observations": ["scan"]}) == [
        "observations[0]: 'robot_0' has no range sensor: add one, or a substitute such as "
        "'without_sensor: nearest_bodies'"
    ]
    for given in ("free_travel", ["route", "free_travel"]):
        circular = {"name": "blank", "observations": [{"name": "scan", "without_sensor": given}]}
        assert messages(scenario({"sensors": None}), circular) == [
            "observations[0].without_sensor: 'free_travel' needs a range sensor itself"
        ]
    half = {"name": "blank", "agents": "all", "observations": [{"name": "scan", "without_sensor": "nothing"}]}
    assert messages(scenario([ROBOT, {**ROBOT, "sensors": None}]), half) == [
        "observations[0].without_sensor: 'nothing' needs learners that all have a range sensor, or none of which has "
        "one: 'robot_1' has none"
    ]


def test_nothing_is_shown_to_learners_of_which_none_has_a_sensor() -> None:
    given = [{"name": name, "without_sensor": "nothing"} for name in ("scan", "free_travel")]
    assert names(load_task(scenario({"sensors": None}), {"name": "blank", "observations": given}).observations) == [
        "Scan",
        "FreeTravel",
    ]
    listed = {"name": "blank", "observations": [{"name": "scan", "without_sensor": ["nothing", "goal"]}]}
    assert any("no observation named 'nothing'" in text for text in messages(scenario({"sensors": None}), listed))


def test_learners_need_the_same_beams() -> None:
    other = {**ROBOT, "sensors": [{"name": "lidar2d", "number": 90}]}
    (told, *_) = messages(scenario([ROBOT, other], task={"agents": "all"}))
    assert "with the same beams, all noisy or none: robot_0 has {name: lidar2d, number: " in told
    assert "robot_1 has {name: lidar2d, number: 90, angle_range: 3.14159, noise: false, has_velocity: false}" in told
    assert told.endswith("task: {agents: [NAME, ...]} selects the learners")


# --- the layout of the parts


def test_parts_lie_one_after_the_other() -> None:
    episodes = play(task={"observation_form": "dict"})
    sizes = [(name, len(low), len(high)) for name, low, high in episodes.observation_terms]
    parts = {"scan": 36, "goal": 4, "last_action": 2, "free_travel": 32, "goal_record": 2, "trail": 12}
    assert sizes == [(name, size, size) for name, size in parts.items()]
    assert episodes.n_features == 88
    assert episodes.view.observation.shape == (1, 1, 88)
    assert episodes.view.observation[0, 0, 40:42].tolist() == [-1, 0]


# --- mistakes

OBSERVED = ("scan", "goal", "last_action", "free_travel", "goal_record", "trail")
BAD_FILE = """\
robot:
  kinematics: {name: diff}
  goal: [8, 5]
task:
  name: navigation
  max_stps: 5
  action: {name: discreet}
  observations:
    - {name: scan, sectrs: 12}
    - goel
    - {name: goal, near: -1}
  rewards:
    - name: time
      weight: -2
    - {name: collision, use: 3}
    - {name: speed, use: false}
  endings: arrived
"""


def test_all_mistakes_at_once_with_their_lines(tmp_path: Path) -> None:
    file = tmp_path / "bad.yaml"
    file.write_text(BAD_FILE)
    with pytest.raises(ScenarioError) as caught:
        load_task(load_scenario(file))
    assert caught.value.file == str(file)
    found = [(problem.line, problem.path, problem.message) for problem in caught.value.problems]
    assert found == [
        (6, "task.max_stps", "unknown key (did you mean 'max_steps'?)"),
        (7, "task.action.name", "no action named 'discreet' (did you mean 'discrete'?)"),
        (9, "task.observations[0].sectrs", "unknown key (did you mean 'sectors'?)"),
        (10, "task.observations[1]", "no observation named 'goel' (did you mean 'goal'?)"),
        (11, "task.observations[2].near", "must be > 0, got -1"),
        (14, "task.rewards[0].weight", "must be >= 0, got -2"),
        (15, "task.rewards[1].use", "must be true or false"),
        (16, "task.rewards[2]", "there is no 'speed' among the rewards to leave out"),
        (17, "task.endings", "must be a list, got 'arrived'"),
    ]


def test_mistakes_in_the_file_built_upon_name_that_file(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("observations: [goal]\nrewards:\n  - {name: tyme}\n")
    (tmp_path / "world.yaml").write_text(
        "robot: {kinematics: {name: diff}, goal: [8, 5]}\ntask: {name: mine.yaml, max_steps: 0}\n"
    )
    with pytest.raises(ScenarioError) as caught:
        load_task(load_scenario(tmp_path / "world.yaml"))
    assert caught.value.file == str(tmp_path / "world.yaml")
    elsewhere, here = caught.value.problems
    assert (here.line, here.path, here.message) == (2, "task.max_steps", "must be >= 1, got 0")
    assert elsewhere.path == f"{tmp_path / 'mine.yaml'}:3 rewards[0].name"
    with pytest.raises(ScenarioError) as caught:
        load_task(scenario(), tmp_path / "mine.yaml")
    assert caught.value.file == str(tmp_path / "mine.yaml")
    assert [problem.line for problem in caught.value.problems] == [3]


def test_a_task_file_that_is_missing_is_told_where_it_is_named(tmp_path: Path) -> None:
    file = tmp_path / "world.yaml"
    file.write_text("robot: {kinematics: {name: diff}, goal: [8, 5]}\ntask:\n  name: mine.yaml\n")
    with pytest.raises(FileNotFoundError) as caught:
        load_task(load_scenario(file))
    assert f"{file}:3   task.name: no such file, neither beside this file nor at the given path: 'mine.yaml'" in str(
        caught.value
    )


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ({"observations": [{"name": name, "use": False} for name in OBSERVED]},
         "task.observations: there is no observation: a task needs at least one in its list 'observations'"),
        ({"name": "blank"}, "task.name: there is no observation: a task needs at least one"),
        ({"observations": [{"name": "scan", "without_sensor": "nearest_bodys"}]},
         "no observation named 'nearest_bodys' (did you mean 'nearest_bodies'?)"),
        ({"endings": [{"name": "arrived", "use": False}]}, "rewards[1]: never applies: it needs the ending 'arrived'"),
        ({"name": "navigashun"}, "task.name: no task named 'navigashun' (did you mean 'navigation'?)"),
        ({"name": 3}, "task.name: must be the name or the file of a task, got 3"),
        ({"observations": ["velocity", "velocity"]}, "task.observations[1]: observation 'velocity' is given twice"),
        ({"observations": [7]}, "task.observations[0]: must be a mapping such as {name: scan}, got 7"),
        ({"observation_form": "list"}, "task.observation_form: must be 'flat' or 'dict', got 'list'"),
    ],
)  # fmt: skip
def test_mistakes_of_meaning(section: dict[str, Any], message: str) -> None:
    # The path of a term that stands in navigation.yaml is told from that file.
    assert any(message in text for text in messages(scenario(task=section)))


def test_what_is_said_to_be_used_is_used_whatever_lists_a_task_lacks() -> None:
    ending = {"name": "left_world", "use": True}
    task = load_task(scenario(task={"name": "blank", "observations": ["goal"], "endings": [ending]}))
    assert names(task.endings) == ["LeftWorld"]
    assert names(task.rewards) == []
    (found,) = messages(scenario(task={"rewards": 3, "endings": [ending]}))
    assert found.startswith("task.rewards: ")


def test_rewards_of_which_a_crash_costs_as_much_are_accepted() -> None:
    """4 for a collision, and at most 2 + 0.8 + 0.2 + 1 for a whole episode: what comes before a crash is paid too."""
    assert load_task(scenario(task={"rewards": [{"name": "time", "weight": 3.0}]})).rewards
    found = messages(scenario(task={"rewards": [{"name": "time", "weight": 3.001}]}))
    assert len(found) == 2


def test_rewards_that_make_a_crash_pay_are_refused() -> None:
    found = messages(scenario(task={"rewards": [{"name": "time", "weight": 4.5}]}))
    assert len(found) == 2
    assert all("one that continues can cost 5.5" in text for text in found)
    assert all("raise the former above 5.5, lower the latter, or say" in text for text in found)
    without = {"rewards": [{"name": "collision", "use": False}]}
    assert messages(scenario(task=without)) == [
        "task.rewards: an episode that ends as 'collided' costs 0, one that continues can cost 3 "
        "(time 2 + clearance 0.8 + smoothness 0.2): add {name: collision, weight: ...} above 3 to rewards, "
        "lower the latter, or say 'audit: false'"
    ]
    # An ending of one's own is told where it stands, the rewards being those of navigation.yaml.
    (found,) = messages(scenario(task={"endings": ["deadlocked"]}))
    assert found.startswith("task.endings[0]: an episode that ends as 'deadlocked' costs 0, one")
    assert "add {name: deadlock, weight: ...} above 3 to rewards" in found
    assert load_task(scenario(task={**without, "audit": False})).rewards
    # The cheapest collision counts, of those that end the episode.
    task = {"rewards": [{"name": "collision", "weight": 9.0, "robot": 0.5}]}
    assert any("costs 0.5 (collision 0.5), one" in text for text in messages(scenario(task=task)))
    lenient = {**task, "endings": [{"name": "collided", "bodies": ["obstacle", "map"]}]}
    assert load_task(scenario(task=lenient)).endings
    # Nothing to fear where nothing but the time limit ends the episode.
    endless = {"name": "blank", "observations": ["goal"], "rewards": [TIMED]}
    assert load_task(scenario(task=endless)).rewards[0].weight == 2.0


def test_unknown_names_of_the_caller() -> None:
    with pytest.raises(UnknownNameError, match=r"no task named 'navigatoin' \(did you mean 'navigation'\?\)"):
        load_task(scenario(), "navigatoin")
    with pytest.raises(FileNotFoundError):
        load_task(scenario(), "nowhere.yaml")


@pytest.mark.parametrize("text", ["- 1\n", "", "a: 1\na: 2\n", "goal: !!python/object:os.system {}\n"])
def test_files_that_are_no_task(tmp_path: Path, text: str) -> None:
    (tmp_path / "bad.yaml").write_text(text)
    with pytest.raises(ScenarioError):
        load_task(scenario(), tmp_path / "bad.yaml")
