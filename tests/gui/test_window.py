"""A real window: pictures on the screen, keys and mouse that come in, windows that are closed."""

from __future__ import annotations

import subprocess
import sys
import weakref

import matplotlib
import numpy as np
import pytest
from screen import Screen

from irsim_gym.rendering.windows.window import Window, WindowEvent

TITLE = "a window under test"


@pytest.fixture
def window(screen: Screen):
    opened = Window(300, 200, TITLE)
    yield opened
    opened.close()


def quarters() -> np.ndarray:
    """Return a picture with a colour of its own in each quarter."""
    picture = np.zeros((200, 300, 3), np.uint8)
    picture[:100, :150], picture[:100, 150:] = (250, 0, 0), (0, 250, 0)
    picture[100:, :150], picture[100:, 150:] = (0, 0, 250), (250, 250, 0)
    return picture


def test_the_screen_shows_the_picture_pixel_by_pixel(window: Window, screen: Screen, kept_picture) -> None:
    window.show(quarters())
    kept_picture(screen.picture())
    assert np.array_equal(screen.picture(300, 200), quarters())
    window.show(quarters()[::-1])
    assert np.array_equal(screen.picture(300, 200), quarters()[::-1])


def test_a_resized_window_shows_the_picture_as_large_as_fits(window: Window, screen: Screen, until) -> None:
    window.show(quarters())
    screen.resize(TITLE, 700, 400)
    paper = (246, 247, 249)
    until(lambda: tuple(screen.picture(700, 400)[200, 690]) == paper, window.wait)
    shown = screen.picture(700, 400)  # twice as large, with 50 pixels free on the left and on the right
    assert tuple(shown[200, 10]) == paper
    for row, column, colour in ((10, 60, (250, 0, 0)), (10, 640, (0, 250, 0)), (390, 60, (0, 0, 250))):
        assert tuple(shown[row, column]) == colour
    told: list[WindowEvent] = []
    window.connect("mouse_press", told.append)
    screen.click("right", 250, 100)
    until(lambda: len(told) > 0, window.wait)
    assert (told[0].column, told[0].row, told[0].button) == (100.0, 50.0, 3)


def test_keys_and_mouse_come_in(window: Window, screen: Screen, until) -> None:
    pressed: list[str] = []
    turned: list[float] = []
    window.connect("key_press", lambda event: pressed.append(event.key))
    window.connect("scroll", lambda event: turned.append(event.steps))
    screen.move(20, 20)
    screen.focus(TITLE)
    screen.type("w", "alt+3", "shift+z", "Escape", "space", "F5")
    screen.click("up", 20, 20)
    screen.click("down", 20, 20)
    until(lambda: len(turned) == 2, window.wait)
    assert pressed == ["w", "alt", "alt+3", "shift", "Z", "escape", " ", "f5"]
    assert turned == [1.0, -1.0]


def test_keys_of_matplotlib_do_nothing(window: Window, screen: Screen, until) -> None:
    pressed: list[str] = []
    window.connect("key_press", lambda event: pressed.append(event.key))
    screen.move(20, 20)
    screen.focus(TITLE)
    screen.type("q", "ctrl+w", "s", "f")  # quit, quit, save, full screen
    until(lambda: "f" in pressed, window.wait)
    assert not window.closed
    assert screen.has_window(TITLE)


def test_a_window_that_the_person_closes_is_noticed(window: Window, screen: Screen, until) -> None:
    window.show(quarters())
    screen.close_window(TITLE)
    until(lambda: window.closed, window.wait)
    window.show(quarters())
    window.wait(10.0)  # returns at once
    assert not screen.has_window(TITLE)


def test_a_closed_window_is_gone(window: Window, screen: Screen) -> None:
    assert screen.has_window(TITLE)
    window.close()
    window.close()
    assert window.closed
    assert not screen.has_window(TITLE)


def test_nothing_of_a_closed_window_is_left_to_other_threads(screen: Screen) -> None:
    """Tk's objects complain when the collection of garbage in another thread frees them."""
    closed = [Window(60, 40, TITLE) for _ in range(2)]
    kept = [weakref.ref(window._canvas) for window in closed]
    assert all(one() is not None for one in kept)
    closed[0].close()
    screen.close_window(TITLE)  # the other one, as a person does
    closed[1].wait(10.0)
    assert [one() for one in kept] == [None, None]


def test_pyplot_stays_as_it_was(window: Window) -> None:
    """Neither pyplot nor a backend is loaded for the user, whose own figures stay without windows."""
    assert matplotlib.rcParams["toolbar"] == matplotlib.rcParamsDefault["toolbar"]
    program = (
        "import sys\n"
        "from irsim_gym.rendering.windows.window import Window\n"
        "window = Window(30, 20)\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
        "import matplotlib.pyplot as plt\n"
        "assert plt.get_fignums() == []\n"
        "plt.close('all')\n"
        "assert not window.closed\n"
        "window.close()\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
