"""Notebooks ask objects for ``_repr_png_`` and ``_repr_html_``; to all others a picture is a plain array."""

from __future__ import annotations

import base64
import copy
import io
import pickle
import re
from pathlib import Path

import imageio.v2 as imageio
import numpy as np
import pytest
import torch
from PIL import Image

import irsim_gym
from irsim_gym.rendering.windows.picture import NotebookPicture, PictureList

WORLD = {"plot": {"figure_pixels": [120, 100]}, "sample_time": 0.2}
SCENARIO = {"world": WORLD, "robot": {"kinematics": {"name": "diff"}, "state": [1, 5, 0], "goal": [9, 5, 0]}}


@pytest.fixture
def picture() -> NotebookPicture:
    env = irsim_gym.make(SCENARIO, render_mode="rgb_array")
    env.reset(seed=0)
    return env.render()


def decoded(content: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(content)))


def test_what_render_returns_is_shown(picture: NotebookPicture) -> None:
    assert isinstance(picture, np.ndarray)
    content = picture._repr_png_()
    assert content is not None
    assert np.array_equal(decoded(content), picture)
    envs = irsim_gym.make_vec(SCENARIO, 2, render_mode="rgb_array")
    envs.reset(seed=0)
    for shown in (*envs.render(), envs.tiled(), irsim_gym.load(SCENARIO).render()):
        assert np.array_equal(decoded(shown._repr_png_()), shown)


def test_parts_are_shown_where_they_are_pictures(picture: NotebookPicture) -> None:
    part = picture[10:50, ::2]
    assert np.array_equal(decoded(part._repr_png_()), np.asarray(part))
    for other in (picture[0], picture[..., 0], picture.astype(np.float32), picture[:0], picture[None]):
        assert other._repr_png_() is None
        assert "NotebookPicture" in repr(other)


def test_what_is_computed_is_a_plain_array(picture: NotebookPicture) -> None:
    plain = np.asarray(picture)
    for made, expected in (
        (picture / 255, plain / 255),
        (255 - picture, 255 - plain),
        (picture > 100, plain > 100),
        (picture.mean(axis=2), plain.mean(axis=2)),
        (picture + plain, plain + plain),
    ):
        assert type(made) is np.ndarray
        np.testing.assert_array_equal(made, expected)
    assert isinstance(picture.mean(), np.floating)
    assert picture.max() == plain.max()
    np.testing.assert_array_equal(picture, plain)
    assert np.array_equal(torch.as_tensor(picture.copy()).numpy(), plain)
    assert np.array_equal(np.asarray(Image.fromarray(picture)), plain)


def test_copies_are_pictures(picture: NotebookPicture) -> None:
    for copied in (picture.copy(), copy.deepcopy(picture), pickle.loads(pickle.dumps(picture))):
        assert type(copied) is NotebookPicture
        assert not np.shares_memory(copied, picture)
        assert np.array_equal(copied, picture)


def test_lists_are_shown_as_films(tmp_path: Path) -> None:
    env = irsim_gym.make(SCENARIO, render_mode="rgb_array_list")
    env.reset(seed=0)
    for _ in range(8):
        env.step(np.array([0.5, 0.0], np.float32))
    pictures = env.render()
    assert isinstance(pictures, list)
    shown = pictures._repr_html_()
    film = tmp_path / "film.mp4"
    film.write_bytes(base64.b64decode(re.search('src="data:video/mp4;base64,([^"]+)"', shown)[1]))
    with imageio.get_reader(film) as reader:
        assert (reader.count_frames(), reader.get_meta_data()["fps"]) == (5, 5.0)
    poster = base64.b64decode(re.search('poster="data:image/png;base64,([^"]+)"', shown)[1])
    assert np.array_equal(decoded(poster), pictures[-1])
    assert 'width="120" height="100"' in shown
    assert pickle.loads(pickle.dumps(pictures)).fps == pictures.fps == 5.0


def test_lists_of_other_things_are_shown_as_lists(picture: NotebookPicture) -> None:
    assert PictureList()._repr_html_() is None
    assert PictureList([picture, picture[1:]])._repr_html_() is None
    assert PictureList([picture[0]])._repr_html_() is None
