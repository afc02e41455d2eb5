"""The mirror of every observation and action, against worlds that are drawn and driven mirrored."""

from __future__ import annotations

import re
from collections.abc import Iterator
from copy import deepcopy
from typing import Any, ClassVar

import numpy as np
import pytest

import irsim_gym
from irsim_gym.envs.parts.mirror import Mirror
from irsim_gym.errors import IrsimGymError, KindError
from irsim_gym.plugins import KINEMATICS, OBSERVATIONS, Mirrored, kind

HEIGHT = 10.0
LIDAR = {"name": "lidar2d", "number": 180, "angle_range": 4.0, "range_max": 4.0}
SCENE: dict[str, Any] = {
    "world": {"width": 10, "height": HEIGHT, "collision_mode": "unobstructed"},
    "robot": [
        {
            "kinematics": {"name": "diff"},
            "shape": {"name": "rectangle", "length": 0.5, "width": 0.3},
            "state": [2.03, 4.01, 0.3],
            "goal": [8.0, 6.2, 1.0],
            "vel_min": [-0.5, -1.2],
            "vel_max": [1.0, 1.2],
            "sensors": [LIDAR],
        },
        {
            "kinematics": {"name": "diff"},
            "state": [6.0, 3.0, 2.0],
            "goal": [1.0, 6.5, 0.0],
            "behavior": {"name": "dash"},
        },
    ],
    "obstacle": [
        {"shape": {"name": "circle", "radius": 0.45}, "state": [4.07, 5.93, 0.0]},
        {"shape": {"name": "rectangle", "length": 1.3, "width": 0.6}, "state": [3.3, 2.6, 0.7]},
        {
            "kinematics": {"name": "omni"},
            "shape": {"name": "circle", "radius": 0.3},
            "state": [5.5, 7.0, 0.0],
            "goal": [2.0, 3.6, 0.0],
            "behavior": {"name": "dash"},
        },
    ],
}
IN_WORLD = {"position", "heading"}
ROUGH = {"seen_map_image", "occupancy_image", "trail", "route"}
ROUGH |= {"way_on_seen_map", "yielding_way"}
"""Observations with cells or pixels, at whose edges a rounding may decide."""
WAYS = {"route", "way_on_seen_map", "yielding_way"}
"""Observations of a way along cells; of two equal ones, the search takes one."""
TRACKED = {"tracks", "time_to_tracks"}
"""Observations that match bodies with clusters in turns; where two bodies claim one, it matters who comes first."""
PUSHED = {"movable_bodies", "contact"}
"""Observations of bodies that push each other."""
OPTIONS: list[Any] = [
    {"scan": {"sectors": 90}},
    {"scan": {"sectors": 7}},
    {"past_scans": {"sectors": 7, "ago": [1, 4, 9]}},
    {"free_travel": {"directions": 9}},
    {"exact_free_travel": {"directions": 3}},
    {"time_to_collision": {"directions": 9, "speeds": 3}},
    {"trail": {"sectors": 5}},
    {"occupancy_image": {"from_scan": True, "robot_channel": True}},
    {"nearest_bodies": {"count": 2}},
    {"neighbors": {"count": 3}},
]
DRIVES = {"diff": 2, "omni": 2, "omni_angular": 3, "acker": 2}


def flipped(pose: Any) -> list[float]:
    """Return a pose in the mirrored world."""
    return [pose[0], HEIGHT - pose[1], *(-angle for angle in pose[2:])]


def mirrored_scene(scene: dict[str, Any]) -> dict[str, Any]:
    """Return a scene whose upper and lower sides are exchanged."""
    other = deepcopy(scene)
    for body in (*other["robot"], *other["obstacle"]):
        body["state"] = flipped(body["state"])
        if "goal" in body:
            body["goal"] = flipped(body["goal"])
    return other


def scene_of(drive: str = "diff", **robot: Any) -> dict[str, Any]:
    """Return the scene with another drive and other keys of the learner."""
    scene = deepcopy(SCENE)
    size = DRIVES[drive]
    limits = {"vel_min": [-0.5, *[-0.9] * (size - 1)], "vel_max": [1.0, *[0.9] * (size - 1)]}
    kinematics = {"name": drive, **({"wheelbase": 0.3} if drive == "acker" else {})}
    scene["robot"][0] |= {"kinematics": kinematics, **limits, **robot}
    return scene


def pushing_scene(drive: str) -> dict[str, Any]:
    """Return the scene with bodies that push each other: one stands ahead of the learner."""
    scene = scene_of(drive)
    scene["world"]["collision_mode"] = "contact"
    box = {"shape": {"name": "rectangle", "length": 0.4, "width": 0.3}, "mass": 0.4}
    ahead = {**box, "state": [2.6, 4.2, 0.5], "goal": [6.0, 5.0, 0.0]}
    scene["obstacle"] += [ahead, {**box, "state": [7.5, 8.0, -0.4], "goal": [6.0, 5.5, 0.0]}]
    return scene


def make(scene: dict[str, Any], *observations: Any, **task: Any) -> Any:
    """Return one world whose task has these observations."""
    names = [one if isinstance(one, str) else next(iter(one)) for one in observations]
    options = [{} if isinstance(one, str) else one[name] for one, name in zip(observations, names, strict=True)]
    observed = [{"name": name, **option} for name, option in zip(names, options, strict=True)]
    return irsim_gym.make_vec(scene, 1, task={"name": "blank", "observations": observed, **task}, max_steps=500)


def both(scene: dict[str, Any], *observations: Any, steps: int = 50, **task: Any) -> tuple[Mirror, Any, Any]:
    """Play a scene and its mirrored one with mirrored actions; return the mirror and what was observed in each."""
    env, other = make(scene, *observations, **task), make(mirrored_scene(scene), *observations, **task)
    mirror = env.unwrapped.mirror()
    random, here, there = np.random.default_rng(0), [env.reset(seed=0)[0]], [other.reset(seed=0)[0]]
    for _ in range(steps):
        if env.single_action_space.shape:
            action = np.float32(random.uniform([0.2, *[-1.0] * (env.single_action_space.shape[0] - 1)], 1.0))[None]
        else:
            action = random.integers(env.single_action_space.n, size=1)
        here.append(env.step(action)[0])
        there.append(other.step(mirror.actions(action))[0])
    if isinstance(here[0], dict):
        pile = [{key: np.concatenate([one[key] for one in rows]) for key in here[0]} for rows in (here, there)]
        return mirror, *pile
    return mirror, np.concatenate(here), np.concatenate(there)


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("name", sorted(set(OBSERVATIONS.names()) - IN_WORLD))
def test_a_mirrored_observation_is_that_of_the_mirrored_world(name: str, drive: str) -> None:
    if name in PUSHED:  # until several bodies touch: who is parted first depends on y, as in IR-SIM
        check_mirror(pushing_scene(drive), name, steps=25)
    elif name in TRACKED:  # until two bodies claim a cluster
        check_mirror(scene_of(drive), name, steps=19)
    else:
        check_mirror(scene_of(drive), name)


@pytest.mark.parametrize("observed", OPTIONS, ids=str)
def test_other_options(observed: dict[str, Any]) -> None:
    check_mirror(scene_of(), observed)


def test_pictures_of_what_can_be_pushed() -> None:
    check_mirror(pushing_scene("diff"), {"occupancy_image": {"movable_channel": True}}, steps=25)


@pytest.mark.parametrize("number", [36, 72, 181])
def test_other_numbers_of_beams(number: int) -> None:
    for observed in ({"scan": {"sectors": 36 if number < 181 else 181}}, "free_travel", "past_scans"):
        check_mirror(scene_of(sensors=[{**LIDAR, "number": number}]), observed)


@pytest.mark.parametrize("offset", [[0.1, 0.0, 0.0], [-0.1, 0.0, np.pi]])
def test_a_sensor_ahead_and_one_that_looks_back(offset: list[float]) -> None:
    for observed in ("scan", "free_travel", "past_scans"):
        check_mirror(scene_of(sensors=[{**LIDAR, "offset": offset}]), observed)


def test_a_car_that_is_steered_by_its_turn_rate() -> None:
    kinematics = {"name": "acker", "mode": "angular", "wheelbase": 0.3}
    for observed in ("velocity", "goal", "last_action"):
        check_mirror(scene_of(kinematics=kinematics), observed)


def check_mirror(scene: dict[str, Any], observed: Any, steps: int = 50) -> None:
    """Compare a mirrored observation with that of the mirrored world."""
    name = observed if isinstance(observed, str) else next(iter(observed))
    mirror, here, there = both(scene, observed, steps=steps)
    changed = mirror.observation(here)
    assert changed.shape == there.shape
    apart = np.abs(changed.astype(np.float64) - there)
    scale = 255.0 if there.dtype == np.uint8 else 1.0
    unlike = np.abs(here.astype(np.float64) - there)
    if name not in ("drive", "own_body", "goal_record", "has_arrived"):
        assert unlike.max() > 0.01 * scale  # the scene is not symmetrical
    if name in ROUGH:
        assert apart.mean() < (0.15 if name in WAYS else 0.02) * unlike.mean()
    else:
        np.testing.assert_allclose(changed, there, atol=2e-3)


@pytest.mark.parametrize("drive", DRIVES)
def test_a_mirrored_choice_has_the_mirrored_effect(drive: str) -> None:
    action = {"name": "discrete", "linear": 2, "lateral": 3 if DRIVES[drive] == 3 else 1, "angular": 5}
    mirror, here, there = both(scene_of(drive), "velocity", "goal", action=action)
    np.testing.assert_allclose(mirror.observation(here), there, atol=1e-4)
    choices = np.arange(mirror.choices.size)
    assert sorted(mirror.choices) == choices.tolist()
    assert np.array_equal(mirror.actions(mirror.actions(choices)), choices)


def test_twice_mirrored_is_unchanged() -> None:
    names = [name for name in OBSERVATIONS.names() if name not in IN_WORLD | PUSHED]
    mirror, here, _ = both(scene_of(), *names, steps=5)
    again = mirror.observation(mirror.observation(here))
    assert set(again) == set(here) == {"vector", "occupancy_image", "seen_map_image"}
    for key, part in here.items():
        np.testing.assert_array_equal(again[key], part)
    turned = mirror.observation(
        {"occupancy_image": here["occupancy_image"].transpose(0, 3, 1, 2)}, channels_first=True
    )["occupancy_image"]
    np.testing.assert_array_equal(turned.transpose(0, 2, 3, 1), mirror.observation(here)["occupancy_image"])


def test_observations_as_a_dict() -> None:
    mirror, here, there = both(scene_of(), "scan", "goal", "velocity", "occupancy_image", observation_form="dict")
    changed = mirror.observation(here)
    assert set(changed) == {"scan", "goal", "velocity", "occupancy_image"}
    for key in ("scan", "goal", "velocity"):
        np.testing.assert_allclose(changed[key], there[key], atol=2e-3)
    apart = np.abs(changed["occupancy_image"].astype(float) - there["occupancy_image"])
    assert apart.mean() < 0.02 * np.abs(here["occupancy_image"].astype(float) - there["occupancy_image"]).mean()


@pytest.fixture
def sway() -> Iterator[Any]:
    """Register an observation of two numbers whose mirror a test chooses."""

    @kind
    class Sway:
        needs_goal: ClassVar[bool] = False
        needs: ClassVar[tuple[str, ...]] = ()
        answer: ClassVar[Any] = None

        def bounds(self, term: Any, model: Any) -> Any:
            return -np.ones(2, np.float32), np.ones(2, np.float32)

        def mirrored(self, term: Any) -> Any:
            return self.answer

        @staticmethod
        def write(term: Any, model: Any, state: Any, episode: Any, shard: Any) -> None:
            heading = state.pose[np.ix_(shard.worlds, term.agents)][..., 2]
            episode.observation[shard.worlds, :, term.column] = np.maximum(np.sin(heading), 0.0)
            episode.observation[shard.worlds, :, term.column + 1] = np.maximum(-np.sin(heading), 0.0)

    OBSERVATIONS.register("sway", Sway)
    yield Sway
    OBSERVATIONS._entries.pop("sway")


def test_a_kind_of_ones_own_says_what_it_becomes(sway: Any) -> None:
    sway.answer = Mirrored(np.array([1, 0]), np.ones(2))
    mirror, here, there = both(scene_of(), "goal", "sway")
    np.testing.assert_array_equal(mirror.vectors[""].columns, [0, 1, 2, 3, 5, 4])
    np.testing.assert_allclose(mirror.observation(here), there, atol=2e-3)
    sway.answer = "is in the frame of the world"
    with pytest.raises(IrsimGymError, match="'sway' is in the frame of the world"):
        make(scene_of(), "sway").unwrapped.mirror()


@pytest.mark.parametrize(
    "answer",
    [
        [1, 0],
        Mirrored(np.array([1, 1]), np.ones(2)),
        Mirrored(np.array([1.0, 0.0]), np.ones(2)),
        Mirrored(np.array([[1, 0]]), np.ones(2)),
        Mirrored([[1], [0, 1]], np.ones(2)),
        Mirrored(np.array([1, 0]), np.array([1.0, -1.0])),
        Mirrored(np.array([1, 0]), np.ones(3)),
        Mirrored(np.array([1, 0]), np.array([1.0, 0.5])),
    ],
)
def test_wrong_mirrors_of_ones_own_kinds(sway: Any, answer: Any) -> None:
    sway.answer = answer
    message = rf"each of the 2 columns once, with 1 or -1, and .* applied twice; got {re.escape(repr(answer))}"
    with pytest.raises(KindError, match=message) as error:
        make(scene_of(), "sway").unwrapped.mirror()
    assert "test_mirror.py" in str(error.value)


def test_a_kind_that_does_not_say_what_it_becomes(sway: Any) -> None:
    del sway.mirrored
    with pytest.raises(IrsimGymError, match="'sway' does not say what it becomes"):
        make(scene_of(), "sway").unwrapped.mirror()


REFUSED: dict[str, Any] = {
    "the observation 'heading' is in the frame of the world": ({}, ["heading"]),
    "'occupancy_image' is in the frame of the world": ({}, [{"occupancy_image": {"rotated": False}}]),
    "the observation 'scan' has beams on the borders of its sectors": (
        {"sensors": [{**LIDAR, "number": 90}]},
        ["scan"],
    ),
    "the shape of 'robot_0' is drawn": ({"shape": {"name": "polygon", "random_shape": True}}, ["goal"]),
    "speed limits of 'robot_0' to the left": (
        {"kinematics": {"name": "omni"}, "vel_min": [-0.5, -0.5], "vel_max": [0.9, 0.9], "speed_range": [0.3, 0.9]},
        ["goal"],
    ),
    "the shape of 'robot_0' is not symmetrical": (
        {"shape": {"name": "polygon", "vertices": [[0, 0], [0.5, 0], [0, 0.3]]}},
        ["goal"],
    ),
    "the range sensor of 'robot_0' is not symmetrical": ({"sensors": [{**LIDAR, "offset": [0.0, 0.1, 0.0]}]}, ["scan"]),
    "the speed limits of 'robot_0' to the left and to the right differ": ({"vel_max": [1.0, 0.4]}, ["goal"]),
}


@pytest.mark.parametrize("message", REFUSED)
def test_what_has_no_mirror_is_refused(message: str) -> None:
    robot, observed = REFUSED[message]
    with pytest.raises(IrsimGymError, match=message):
        make(scene_of(**robot), *observed).unwrapped.mirror()


def test_every_reason_is_named() -> None:
    with pytest.raises(IrsimGymError, match=r"speed limits.*'heading'.*'position'"):
        make(scene_of(vel_max=[1.0, 0.4]), "heading", "goal", "position").unwrapped.mirror()


def test_speeds_that_levels_draw_may_be_symmetrical() -> None:
    limits = {"vel_min": [-0.5, -0.9], "vel_max": [0.9, 0.9], "speed_range": [0.3, 0.9]}
    make(scene_of(kinematics={"name": "omni"}, **limits), "goal").unwrapped.mirror()
    turning = {"vel_min": [-0.5, -0.9, -1], "vel_max": [0.9, 0.9, 1], "speed_range": [0.3, 0.9]}
    make(scene_of(kinematics={"name": "omni_angular"}, **turning), "goal").unwrapped.mirror()


def test_a_sensor_that_nobody_reads_may_stand_aside() -> None:
    make(scene_of(sensors=[{**LIDAR, "offset": [0.0, 0.1, 0.0]}]), "goal").unwrapped.mirror()


def test_actions_in_the_frame_of_the_world_are_refused() -> None:
    env = make(scene_of("omni"), "goal", action={"name": "velocity", "frame": "command"})
    with pytest.raises(IrsimGymError, match="actions are in the frame of the world"):
        env.unwrapped.mirror()


@pytest.fixture
def tracks() -> Iterator[Any]:
    """Return a function that registers a drive with two tracks, and says how its command is mirrored."""

    def register(*mirrored: tuple[int, int]) -> dict[str, Any]:
        KINEMATICS._entries.pop("two_tracks", None)

        @irsim_gym.drive("two_tracks", command=("left", "right"), mirrored_command=mirrored)
        def two_tracks(ego: Any, command: Any) -> Any:
            left, right = command
            return (left + right) / 2, 0.0, (right - left) / 0.5

        return scene_of(kinematics={"name": "two_tracks"}, vel_min=[-0.3, -0.3], vel_max=[1.0, 1.0])

    yield register
    KINEMATICS._entries.pop("two_tracks", None)


def test_a_drive_with_two_tracks_exchanges_them(tracks: Any) -> None:
    scene = tracks((1, 1), (0, 1))
    for observed in ("velocity", "last_action", "goal"):
        check_mirror(scene, observed)
    mirror = make(scene, "goal").unwrapped.mirror()
    np.testing.assert_array_equal(mirror.actions(np.array([[0.1, -0.7]])), [[-0.7, 0.1]])
    mirror, here, there = both(scene, "velocity", "goal", action={"name": "discrete", "linear": 3, "angular": 3})
    np.testing.assert_allclose(mirror.observation(here), there, atol=1e-4)
    assert mirror.choices.tolist() == [0, 3, 6, 1, 4, 7, 2, 5, 8]


def test_a_drive_that_cannot_be_mirrored_is_refused(tracks: Any) -> None:
    scene = tracks()
    with pytest.raises(IrsimGymError, match="'velocity' is of commands, and the drive 'two_tracks' does not say what"):
        make(scene, "velocity").unwrapped.mirror()
    scene = tracks((1, 1), (0, 1))
    with pytest.raises(IrsimGymError, match="not all choices of the action 'discrete' have their mirror image"):
        make(scene, "goal", action={"name": "discrete", "linear": 3, "angular": 5}).unwrapped.mirror()
    scene["robot"][0]["vel_max"] = [1.0, 0.8]
    with pytest.raises(IrsimGymError, match="limits of 'robot_0' to the left and to the right differ"):
        make(scene, "goal").unwrapped.mirror()
    scene = tracks((1, 1), (0, 1))
    scene["robot"].append({**scene["robot"][0], "kinematics": {"name": "diff"}, "state": [5, 1, 0]})
    del scene["robot"][1]
    env = irsim_gym.make_vec(scene, 1, task={"name": "blank", "observations": ["goal"]}, max_steps=5)
    assert env.unwrapped.mirror().action.columns.tolist() == [1, 0]
    scene["robot"][1]["vel_min"] = [-0.3, -1.0]
    batch = irsim_gym.make_batch(scene, 1, task={"name": "blank", "observations": ["goal"]})
    with pytest.raises(IrsimGymError, match="of commands of drives that are mirrored in different ways"):
        batch.mirror()


@pytest.mark.parametrize("mirrored", [((0, 1), (0, 1)), ((1, 1), (0, -1)), ((1, 2), (0, 2)), ((0, 1),)])
def test_a_wrong_mirrored_command_is_refused(tracks: Any, mirrored: Any) -> None:
    with pytest.raises(KindError, match="'mirrored_command' must name each of the 2 numbers of a command once"):
        tracks(*mirrored)
