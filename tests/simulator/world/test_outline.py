"""Outlines in the world frame."""

from __future__ import annotations

import numpy as np

from irsim_gym.simulator.world.model import Model
from irsim_gym.simulator.world.outline import outline_of, place_outline
from irsim_gym.simulator.world.state import State
from tests.simulator.geometry.shapes import Floats, closed, star

AXES = ("world", "body", "waypoint", "bucket", "map_column", "map_row", "map_box", "watching")


def body(segments: Floats, discs: Floats) -> tuple[Model, State]:
    """Return a world with one body, which has all rows of the tables."""
    sizes = dict.fromkeys(AXES, 1) | {"segment": len(segments), "disc": len(discs)}
    model, state = Model.allocate(sizes), State.allocate(sizes)
    model.local_segments[0], model.local_discs[0] = segments, discs
    model.segment_count[:], model.disc_count[:] = len(segments), len(discs)
    return model, state


def test_only_the_rows_of_the_body_are_placed() -> None:
    model, state = body(np.arange(16.0).reshape(4, 4), np.array([[1.0, 0.0, 0.5], [0.0, 2.0, 0.25]]))
    model.segment_start[0], model.segment_count[0, 0], model.disc_start[0], model.disc_count[0, 0] = 1, 2, 1, 1
    state.pose[0, 0] = 10.0, 20.0, 0.5 * np.pi
    segments, discs = state.segments[0], state.discs[0]
    segments[:], discs[:] = -1.0, -1.0
    place_outline(model, state, 0, 0)
    assert (segments[[0, 3]] == -1.0).all()
    np.testing.assert_allclose(segments[1], [10 - 5, 20 + 4, 10 - 7, 20 + 6], atol=1e-12)
    np.testing.assert_allclose(discs[1], [10 - 2, 20, 0.25], atol=1e-12)
    assert (discs[0] == -1.0).all()


def test_shared_vertices_stay_shared() -> None:
    model, state = body(closed(star(np.random.default_rng(8), 0.3, -0.2, 0.7)), np.zeros((0, 3)))
    for heading in np.linspace(-3.0, 3.0, 50):
        state.pose[0, 0] = 7.1, -3.3, heading
        place_outline(model, state, 0, 0)
        segments, (cosine, sine) = state.segments[0], (np.cos(heading), np.sin(heading))
        assert (segments[:, 2:] == np.roll(segments[:, :2], -1, axis=0)).all()
        expected = model.local_segments[0, :, :2] @ [[cosine, sine], [-sine, cosine]] + [7.1, -3.3]
        np.testing.assert_allclose(segments[:, :2], expected, rtol=0.0, atol=1e-12)


def test_an_outline_is_that_of_its_world() -> None:
    """Bodies of all worlds share their first rows; worlds may share the numbers of rows, as here."""
    sizes = dict.fromkeys(AXES, 2) | {"segment": 5, "disc": 1}
    model, state = Model.allocate(sizes), State.allocate(sizes)
    model.segment_start[:], model.segment_count[0], model.solid[:] = (0, 2), (2, 3), (True, False)
    state.segments[1], state.segments[0] = 1.0, -1.0
    found = outline_of.py_func(model, state, 1, 1)  # type: ignore[attr-defined]
    assert found.segments.tolist() == [[1.0] * 4] * 5
    assert found[1:3] == (2, 3)
    assert found[4:] == (0, 0, False)
