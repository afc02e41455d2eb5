"""A shape that the vocabulary describes is drawn in frames, figures and pages; nothing else has to know of it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pixels import WAYS, of_world
from replay_pages import read_html

from irsim_gym.live.world import load
from irsim_gym.rendering.scene import vocabulary
from irsim_gym.rendering.scene.primitives import Figure, Ink, Pen, Primitive, Shape

SCENARIO: dict[str, Any] = {
    "robot": {
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": 0.3},
        "state": [2, 2, np.pi / 2],
        "goal": [7, 7, 0],
        "goal_threshold": 0.4,
        "plot": {"show_goal": True, "show_arrow": False},
    }
}
ARROW = np.array([[-2.0, 0.0], [-1.0, 0.4], [-1.0, -0.4], [-2.0, 0.0]])
"""It ends a metre behind where it stands."""


def with_arrows(drawn: Iterator[Primitive], place: np.ndarray | None) -> Iterator[Primitive]:
    yield from drawn
    yield Figure("marks", 2.0, Pen(Ink("#FF00FF"), Ink("#0000FF"), 2.0), Shape((ARROW,)), place)


def test_an_arrow_at_a_goal_and_at_a_body(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    goal, body = vocabulary.goal, vocabulary.body
    at_goal = lambda view: with_arrows(goal(view), np.array([[view.x, view.y]]))  # noqa: E731
    monkeypatch.setattr(vocabulary, "goal", at_goal)
    monkeypatch.setattr(vocabulary, "body", lambda *given, fixed: with_arrows(body(*given, fixed=fixed), None))
    with load(SCENARIO, record=True) as world:
        layout = world._camera.seen()
        for how in WAYS:
            picture = of_world(world, how)
            for x, y in ((5.8, 7.0), (2.0, 0.8)):  # left of the goal, and behind the robot, which heads upwards
                column, row = layout.column_row(x, y)
                assert picture[int(row), int(column)].tolist() == [255, 0, 255], (how, x, y)
        world.step()
        page = read_html(world.save_html(tmp_path / "page.html"))
        (pen,) = (number for number, pen in enumerate(page["pens"]) if pen.get("fill") == "#ff00ff")
        assert [item.get("pen") for item in page["episodes"][0]["items"]].count(pen) >= 2
