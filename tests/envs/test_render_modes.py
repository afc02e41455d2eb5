"""What ``render`` gives in each mode, for environments of all kinds."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path
from typing import Any

import gymnasium
import imageio.v2 as imageio
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers import RecordVideo, RenderCollection
from stable_baselines3.common.vec_env.base_vec_env import tile_images

import irsim_gym
from irsim_gym import sb3
from irsim_gym.envs.gymnasium.single import WorldEnv
from irsim_gym.errors import IrsimGymError, NoWindowError, UnknownKeywordError
from irsim_gym.rendering.windows.screen import Screen

WORLD = {"name": "small", "step_time": 0.05, "sample_time": 0.05, "plot": {"figure_pixels": [120, 100]}}
SPARSE = {**WORLD, "sample_time": 0.16}  # three steps
ROBOT = {"kinematics": {"name": "diff"}, "state": [1, 5, 0], "goal": [9, 5, 0]}
TEAM = {**ROBOT, "number": 2, "state": [[1, 2], [1, 8]]}
AHEAD = np.array([0.5, 0.0], np.float32)
MODES = ["human", "rgb_array", "rgb_array_list"]


def one(world: dict[str, Any], **options: Any) -> gymnasium.Env[Any, Any]:
    return irsim_gym.make({"world": world, "robot": ROBOT}, **options)


FACES = {
    "make": lambda **options: one(WORLD, **options),
    "gym.make": lambda **options: gymnasium.make("irsim_gym/World-v0", scenario={"robot": ROBOT}, **options),
    "make_vec": lambda **options: irsim_gym.make_vec({"world": WORLD, "robot": ROBOT}, 2, **options),
    "parallel": lambda **options: irsim_gym.parallel_env({"world": WORLD, "robot": TEAM}, **options),
    "batch": lambda **options: irsim_gym.make_batch({"world": WORLD, "robot": TEAM}, 2, **options),
    "sb3": lambda **options: sb3.make_vec_env({"world": WORLD, "robot": ROBOT}, 2, **options),
    "sb3_team": lambda **options: sb3.make_multi_agent_vec_env({"world": WORLD, "robot": TEAM}, 2, **options),
}


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch) -> list[tuple[np.ndarray, float]]:
    """Let windows be a list of pictures and of how long each is to wait."""
    pictures: list[tuple[np.ndarray, float]] = []
    monkeypatch.setattr(Screen, "show", lambda self, picture, seconds=0.0: pictures.append((picture, seconds)))
    return pictures


def test_lists_are_gymnasiums_where_each_step_is_a_sample() -> None:
    """The oracle is Gymnasium's own wrapper around pictures."""
    ours, theirs = one(WORLD, render_mode="rgb_array_list"), RenderCollection(one(WORLD, render_mode="rgb_array"))
    assert type(ours.unwrapped) is WorldEnv
    assert (ours.render_mode, ours.unwrapped.render_mode) == ("rgb_array_list", "rgb_array_list")
    for begins, steps, takes in ((True, 3, True), (False, 0, True), (False, 2, False), (True, 1, True)):
        for env in (ours, theirs):
            if begins:
                env.reset(seed=0)
            for _ in range(steps):
                env.step(AHEAD)
        if takes:
            assert_pictures(ours.render(), theirs.render())


def test_lists_hold_beginning_samples_and_end() -> None:
    env, twin = (one(SPARSE, render_mode=mode, max_steps=7) for mode in ("rgb_array_list", "rgb_array"))
    assert env.metadata == {"render_modes": MODES, "render_fps": pytest.approx(1 / 0.15)}
    assert twin.metadata["render_fps"] == pytest.approx(20.0)
    expected = []
    for step in range(8):
        if step == 0:
            env.reset(seed=0)
            twin.reset(seed=0)
        else:
            env.step(AHEAD)
            twin.step(AHEAD)
        if step in (0, 3, 6, 7):
            expected.append(twin.render())
    taken = env.render()
    assert taken.fps == pytest.approx(1 / 0.15)
    assert_pictures(taken, expected)
    assert env.render() == []
    env.reset(seed=0)
    env.step(AHEAD)
    env.reset(seed=0)
    assert_pictures(env.render(), expected[:1])


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_copies_keep_what_was_collected(copied: Any) -> None:
    env = one(WORLD, render_mode="rgb_array_list").unwrapped
    env.reset(seed=0)
    env.step(AHEAD)
    other = copied(env)
    for one_of_them in (env, other):
        one_of_them.step(AHEAD)
    assert_pictures(env.render(), other.render())
    assert env.render() == []


@pytest.mark.parametrize("mode", ["rgb_array", "rgb_array_list"])
@pytest.mark.parametrize("autoreset", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_batches_render_as_gymnasiums_do(mode: str, autoreset: AutoresetMode) -> None:
    options = {"render_mode": mode, "max_steps": 3}
    native = irsim_gym.make_vec({"world": WORLD, "robot": ROBOT}, 2, autoreset_mode=autoreset, **options)
    theirs = SyncVectorEnv([lambda: one(WORLD, **options)] * 2, autoreset_mode=autoreset)
    native.reset(seed=5)
    theirs.reset(seed=5)
    for steps in (1, 1, 2, 2):
        for _ in range(steps):
            native.step(np.stack([AHEAD, -AHEAD]))
            theirs.step(np.stack([AHEAD, -AHEAD]))
        ours, others = native.render(), theirs.render()
        assert isinstance(ours, tuple)
        for left, right in zip(ours, others, strict=True):
            if mode == "rgb_array":
                assert np.array_equal(left, right)
            else:
                assert_pictures(left, right)


def test_tiles_are_the_worlds_pictures() -> None:
    envs = irsim_gym.make_vec({"world": WORLD, "robot": ROBOT}, 3, render_mode="rgb_array")
    envs.reset(seed=0)
    envs.step(np.array([[0.9, 0], [0, 0], [0.2, 0.9]]))
    first, second, third = envs.render()
    assert np.array_equal(envs.tiled(3), np.hstack([first, second, third]))
    assert np.array_equal(envs.tiled(1), np.vstack([first, second, third]))
    assert np.array_equal(envs.tiled(2)[:100], np.hstack([first, second]))
    assert np.array_equal(envs.tiled(2)[100:, :120], third)
    assert (envs.tiled(2)[100:, 120:] == [0xF6, 0xF7, 0xF9]).all()
    assert np.array_equal(envs.tiled(worlds=[2]), third)
    assert envs.tiled(1, room=(120, 300)).shape == (300, 120, 3)
    assert envs.tiled(3, [0, 1, 2], room=(354, 1000)).shape == (98, 354, 3)
    for wrong in ({"columns": 0}, {"worlds": []}, {"worlds": [3]}, {"worlds": [0, -1]}):
        with pytest.raises(ValueError, match="at least"):
            envs.tiled(**wrong)
    silent = irsim_gym.make_vec({"world": WORLD, "robot": ROBOT}, 2)
    silent.reset(seed=0)
    with pytest.raises(IrsimGymError, match="use render_mode='rgb_array'"):
        silent.tiled()


def test_a_batch_of_teams_renders() -> None:
    batch = FACES["batch"](render_mode="rgb_array_list")
    batch.reset(0)
    batch.step(np.zeros((2, 2, 2)))
    assert [len(pictures) for pictures in batch.render()] == [2, 2]
    assert np.array_equal(batch.tiled(2)[:, :120], batch.tiled(worlds=[0]))
    assert batch.render_mode == "rgb_array_list"
    batch.close()


def test_a_window_shows_samples_and_ends_in_their_time(shown: list[tuple[np.ndarray, float]]) -> None:
    env, twin = one(SPARSE, render_mode="human", max_steps=4), one(SPARSE, render_mode="rgb_array", max_steps=4)
    expected = []
    for seed in (0, 1):
        env.reset(seed=seed)
        twin.reset(seed=seed)
        expected.append(twin.render())
        for step in range(1, 5):
            env.step(AHEAD)
            twin.step(AHEAD)
            if step in (3, 4):
                expected.append(twin.render())
        assert env.render() is None
    assert_pictures([picture for picture, _ in shown], expected)
    assert [seconds for _, seconds in shown[1:]] == pytest.approx([0.15, 0.05, 0.05, 0.15, 0.05])


def test_a_window_shows_no_more_than_sixteen_worlds(shown: list[tuple[np.ndarray, float]]) -> None:
    envs = irsim_gym.make_vec({"world": WORLD, "robot": ROBOT}, 20, render_mode="human")
    envs.reset(seed=0)
    assert shown[0][0].shape == (400, 480, 3)
    assert envs.render() is None
    assert np.array_equal(shown[0][0], envs.tiled(4, range(16)))


def test_a_team_is_shown_while_it_lasts(shown: list[tuple[np.ndarray, float]]) -> None:
    env = irsim_gym.parallel_env({"world": WORLD, "robot": TEAM}, render_mode="human", max_steps=2)
    env.reset(seed=0)
    for _ in range(3):
        env.step(dict.fromkeys(env.agents, AHEAD))
    assert len(shown) == 3
    assert env.render() is None


def test_stable_baselines_gets_pictures_and_windows(shown: list[tuple[np.ndarray, float]]) -> None:
    env = FACES["sb3"](render_mode="rgb_array", seed=0)
    env.reset()
    env.step(np.stack([AHEAD, -AHEAD]))
    images = env.get_images()
    assert np.array_equal(env.render(), tile_images(images))
    assert env.render("human") is None
    assert np.array_equal(shown[-1][0], np.hstack(images))
    assert shown[-1][1] == pytest.approx(0.05)
    assert np.array_equal(env.env_method("render", indices=1)[0], images[1])
    for _ in range(30):  # a second and a half in the world, in which nobody looked
        env.step(np.stack([AHEAD, -AHEAD]))
    env.render("human")
    assert shown[-1][1] == pytest.approx(1.0)
    watched = FACES["sb3"](render_mode="human", seed=0)
    watched.reset()
    before = len(shown)
    watched.step(np.stack([AHEAD, -AHEAD]))
    watched.render("human")
    watched.render()
    assert len(shown) == before + 1
    assert np.array_equal(shown[-1][0], np.hstack(images))
    silent = FACES["sb3"](render_mode=None)
    with pytest.warns(UserWarning, match="render_mode='rgb_array'"):
        assert silent.get_images() == [None, None]


@pytest.mark.filterwarnings("ignore:.*not in the possible render_modes")  # Gymnasium's, beside our error
@pytest.mark.parametrize("face", FACES)
def test_what_cannot_be_shown_is_said(face: str, monkeypatch: pytest.MonkeyPatch) -> None:
    make = FACES[face]
    with pytest.raises(ValueError, match="render_mode must be None"):
        make(render_mode="nothing")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    env = make(render_mode="human")
    with pytest.raises(NoWindowError, match=r"no display.*render_mode='rgb_array'"):
        env.reset()
    env.close()


def test_an_option_of_old_releases_is_taken_or_explained() -> None:
    """Frames are always drawn by what was called raster."""
    old = irsim_gym.make("empty_goal", render_mode="rgb_array", render_backend="raster")
    new = irsim_gym.make("empty_goal", render_mode="rgb_array")
    for env in (old, new):
        env.reset(seed=0)
    assert np.array_equal(old.render(), new.render())
    for make in (irsim_gym.make, irsim_gym.make_vec, irsim_gym.load):
        with pytest.raises(UnknownKeywordError, match=r"one renderer.*leave it out; matplotlib writes figures"):
            make("empty_goal", render_backend="matplotlib")


def test_stable_baselines_knows_no_lists() -> None:
    with pytest.raises(ValueError, match="'rgb_array' or 'human' for Stable-Baselines3, got 'rgb_array_list'"):
        FACES["sb3"](render_mode="rgb_array_list")


def assert_pictures(ours: Any, expected: Any) -> None:
    assert isinstance(ours, list)
    assert len(ours) == len(expected)
    for left, right in zip(ours, expected, strict=True):
        assert (left.dtype, left.ndim) == (np.uint8, 3)
        assert np.array_equal(left, right)


@pytest.mark.filterwarnings("ignore:.*has just been called")  # the recorder's, between samples
@pytest.mark.parametrize(("mode", "frames", "fps"), [("rgb_array", 8, 20.0), ("rgb_array_list", 4, 1 / 0.15)])
def test_gymnasiums_films_run_in_real_time(mode: str, frames: int, fps: float, tmp_path: Path) -> None:
    """A picture of each step, or of the beginning, of steps 3 and 6 and of the end after step 7."""
    env = RecordVideo(one(SPARSE, render_mode=mode, max_steps=7), str(tmp_path / "films"), disable_logger=True)
    env.reset(seed=0)
    for _ in range(7):
        env.step(AHEAD)
    assert len(env.recorded_frames) == frames
    env.close()
    (film,) = tmp_path.glob("films/*.mp4")
    with imageio.get_reader(film) as reader:
        assert reader.count_frames() in (frames - 1, frames)  # moviepy rounds lengths down: it may lose the last one
        assert reader.get_meta_data()["fps"] == pytest.approx(fps, abs=0.01)


def test_an_end_stays_in_the_window_where_the_next_episode_begins_at_once(
    shown: list[tuple[np.ndarray, float]],
) -> None:
    envs = irsim_gym.make_vec(
        {"world": WORLD, "robot": ROBOT}, 2, render_mode="human", max_steps=2, autoreset_mode="SameStep"
    )
    envs.reset(seed=0)
    for _ in range(4):
        envs.step(np.stack([AHEAD, AHEAD]))
    _, first, first_end, second, second_end = (picture for picture, _ in shown)
    assert np.array_equal(first, second)
    assert np.array_equal(first_end, second_end)
    assert not np.array_equal(first, first_end)
    assert [seconds for _, seconds in shown[1:]] == pytest.approx([0.05] * 4)
