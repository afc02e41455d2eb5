"""Where the mouse is in the world, and zooming, with events that are made up."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from irsim_gym.rendering.controls.mouse import Mouse
from irsim_gym.rendering.scene.frame_layout import Layout, lay_out
from irsim_gym.rendering.windows.window import WindowEvent


class Watched:
    """Stands for a window: keeps whom it would call."""

    def __init__(self) -> None:
        self.told: dict[str, Callable[[WindowEvent], None]] = {}

    def connect(self, name: str, callback: Callable[[WindowEvent], None]) -> None:
        self.told[name] = callback


@pytest.fixture
def layout() -> Layout:
    return lay_out(np.array([0.0, 0.0, 10.0, 10.0]))


def at(layout: Layout, x: float, y: float, **more: Any) -> WindowEvent:
    column, row = layout.column_row(x, y)
    return WindowEvent(column=column, row=row, **more)


def test_clicks_are_kept_and_rounded(layout: Layout) -> None:
    window: Any = Watched()
    mouse = Mouse(window, 2.0, lambda: layout)
    window.told["mouse_press"](at(layout, 1.23456, 9.0, button=1))
    window.told["mouse_press"](at(layout, 4.0, 5.00499, button=3))
    assert (mouse.left, mouse.right) == ((1.23, 9.0), (4.0, 5.0))
    assert mouse.position == pytest.approx((4.0, 5.00499))
    window.told["mouse_press"](WindowEvent(column=2.0, row=2.0, button=1))  # in the margin
    assert (mouse.left, mouse.position) == ((1.23, 9.0), None)
    window.told["mouse_move"](at(layout, 3.0, 3.0))
    window.told["mouse_leave"](WindowEvent())
    assert mouse.position is None


def test_zooming_keeps_the_point_under_the_cursor(layout: Layout) -> None:
    """Two steps of a factor of 2 show a quarter; its edges are as far away, each by a quarter, as they were."""
    window: Any = Watched()
    mouse = Mouse(window, 2.0, lambda: layout)
    assert mouse.new_limits() == (False, None)
    for _ in range(2):
        window.told["scroll"](at(layout, 2.0, 6.0, steps=1.0))
    x_min, y_min, x_max, y_max = layout.limits
    wanted = (2 - (2 - x_min) / 4, 6 - (6 - y_min) / 4, 2 + (x_max - 2) / 4, 6 + (y_max - 6) / 4)
    changed, limits = mouse.new_limits()
    assert changed
    assert limits == pytest.approx(wanted)
    assert mouse.new_limits()[0] is False
    window.told["mouse_press"](at(layout, 2.0, 6.0, button=2))
    assert mouse.new_limits() == (True, None)
    assert (mouse.left, mouse.right) == (None, None)
    window.told["scroll"](WindowEvent(column=1.0, row=1.0, steps=1.0))  # in the margin
    assert mouse.new_limits() == (False, None)
