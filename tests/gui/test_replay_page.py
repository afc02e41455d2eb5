"""A replay in a real browser: what is drawn where, what keys and the mouse do, and a console without errors."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import browser

import irsim_gym
from irsim_gym.evaluation.comparison.record import record_html
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.rendering.scene import vocabulary
from irsim_gym.rendering.scene.primitives import Figure, Ink, Pen, Primitive, Shape
from irsim_gym.rendering.scene.scene import GoalView

ROOM = """
world: {height: 6, width: 8, step_time: 0.1}
robot:
  - kinematics: {name: diff}
    shape: {name: circle, radius: 0.3}
    state: [1, 3.3, 0]
    goal: [7, 3.3, 0]
    color: '#00ff00'
    sensors: [{name: lidar2d, number: 60, angle_range: 2 * pi, range_max: 2}]
  - kinematics: {name: diff}
    shape: {name: rectangle, length: 0.6, width: 0.4}
    state: [7, 1, 3.14159]
    goal: [1, 1, 0]
    color: '#0000ff'
obstacle: [{shape: {name: circle, radius: 0.5}, state: [4, 4.6], color: '#ff0000'}]
task: {name: navigation, max_steps: 90}
"""
GREEN, BLUE, RED, WHITE = (0, 255, 0), (0, 0, 255), (255, 0, 0), (255, 255, 255)


class Page:
    """The page under test, and what a person sees of it."""

    def __init__(self, driver: Any) -> None:
        self.driver = driver

    def run(self, script: str) -> Any:
        return self.driver.execute_script(script)

    def press(self, *keys: str) -> None:
        from selenium.webdriver.common.action_chains import ActionChains

        chain = ActionChains(self.driver, duration=0)
        for key in keys:
            chain.send_keys(key)
        chain.perform()
        self.settle()

    def click(self, name: str) -> None:
        self.driver.find_element("id", name).click()
        self.settle()

    def settle(self) -> None:
        """Wait until what is due is drawn."""
        self.driver.execute_async_script(
            "const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => done()))"
        )

    @property
    def moment(self) -> int:
        return int(self.run("return player.moment"))

    def picture(self) -> np.ndarray:
        """Return what the window shows, uint8, shape ``(height, width, 3)``."""
        from PIL import Image

        return np.asarray(Image.open(io.BytesIO(self.driver.get_screenshot_as_png())).convert("RGB"))

    def colour(self, x: float, y: float) -> tuple[int, int, int]:
        """Return the colour at a point of the world [m]."""
        left, top = self.run("const b = byId('world').getBoundingClientRect(); return [b.left, b.top]")
        column, row = self.run(f"return [player.world.column({x}), player.world.row({y})]")
        return tuple(self.picture()[round(top + row), round(left + column)].tolist())

    def seen(self) -> np.ndarray:
        """Return the pixels of the canvas that shows the world."""
        left, top, width, height = self.run(
            "const b = byId('world').getBoundingClientRect(); return [b.left, b.top, b.width, b.height]"
        )
        return self.picture()[round(top) : round(top + height), round(left) : round(left + width)]

    def problems(self) -> list[dict[str, Any]]:
        return list(self.driver.get_log("browser"))


@pytest.fixture(scope="module")
def replay(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("replay")
    (folder / "room.yaml").write_text(ROOM, encoding="utf-8")
    return record_html(
        ScenarioRequest(str(folder / "room.yaml"), team=True), ["dash", "random"], [0], folder / "room.html"
    )


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with browser(tmp_path_factory.mktemp("profile")) as started:
        yield started


@pytest.fixture
def page(driver: Any, replay: Path) -> Iterator[Page]:
    open_page(driver, replay, 1200, 900)
    opened = Page(driver)
    yield opened
    assert opened.problems() == []


def open_page(
    driver: Any, replay: Path, width: int, height: int, scheme: str = "light", *, mobile: bool = False
) -> None:
    screen = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": mobile}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
    driver.get(replay.as_uri())
    wait(driver, "return Boolean(window.player)")
    Page(driver).settle()


def wait(driver: Any, script: str) -> None:
    from selenium.webdriver.support.ui import WebDriverWait

    WebDriverWait(driver, 10, 0.02).until(lambda found: found.execute_script(script))


def test_the_start_is_drawn_where_it_is(page: Page) -> None:
    assert page.colour(0.85, 3.45) == GREEN
    assert page.colour(7.2, 1.1) == BLUE
    assert page.colour(4.0, 4.6) == RED
    assert page.colour(4.3, 5.5) == WHITE
    assert page.colour(1.0, 3.3) == WHITE  # the mark of its heading


def test_scrubbing_moves_the_robots(page: Page) -> None:
    page.run("byId('moment').value = 30; byId('moment').dispatchEvent(new Event('input'))")
    page.settle()
    x, y = page.run("return [...player.episode.bodies.find((body) => body.name === 'robot_0').place.row(30)]")
    assert x > 3.0
    assert page.colour(x - 0.15, y + 0.15) == GREEN
    assert page.colour(0.85, 3.45) != GREEN
    assert page.run("return byId('clock').textContent").startswith("3.0 / ")


def test_keys(page: Page) -> None:
    from selenium.webdriver.common.keys import Keys

    page.press(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.ARROW_LEFT)
    assert page.moment == 1
    page.press(Keys.END)
    assert page.moment == page.run("return player.episode.count - 1")
    page.press(Keys.HOME)
    assert page.moment == 0
    page.press(Keys.ARROW_UP)
    assert page.run("return byId('speed').value") == "2"
    page.press("l", Keys.PAGE_DOWN)
    assert page.run("return [byId('loop').checked, player.number]") == [True, 1]
    page.press("+", "+")
    assert page.run("return player.world.look.zoom") == pytest.approx(1.25**2)
    page.press("0")
    assert page.run("return player.world.look.zoom") == 1


def test_playing_runs_and_stops_at_the_end(page: Page) -> None:
    page.press(" ")
    wait(page.driver, "return player.moment >= 3")
    page.press(" ")
    held = page.moment
    before = page.seen()
    page.settle()
    assert page.moment == held
    assert np.array_equal(page.seen(), before)
    page.run("byId('speed').value = '16'; player.play(true)")
    wait(page.driver, "return !player.isPlaying")
    assert page.moment == page.run("return player.episode.count - 1")
    page.click("play")  # from the start again
    wait(page.driver, "return player.moment > 0 && player.moment < player.episode.count - 1")


@pytest.mark.parametrize(("key", "where"), [("s", (3.6, 3.6)), ("t", (2.2, 3.3)), ("n", None)])
def test_what_is_shown_can_be_chosen(page: Page, key: str, where: tuple[float, float] | None) -> None:
    """Scans, paths and names come and go; the ground is seen where they were."""
    page.run("player.go(16)")
    page.press("s" if key == "t" else "")  # a path is seen best without the scan over it
    before = page.seen()
    assert where is None or page.colour(*where) != WHITE
    page.press(key)
    after = page.seen()
    assert 20 < (before != after).any(axis=2).sum() < 0.5 * before[..., 0].size
    assert where is None or page.colour(*where) == WHITE
    page.press(key)
    assert np.array_equal(page.seen(), before)


def test_the_wheel_zooms_about_the_mouse_and_dragging_moves(page: Page) -> None:
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.actions.wheel_input import ScrollOrigin

    canvas = page.driver.find_element("id", "world")
    under = "return player.world.pointAt(...[byId('world').clientWidth / 2 + 60, byId('world').clientHeight / 2 + 40])"
    before = page.run(under)
    origin = ScrollOrigin.from_element(canvas, 60, 40)
    ActionChains(page.driver).scroll_from_origin(origin, 0, -600).perform()
    page.settle()
    assert page.run("return player.world.look.zoom") > 2
    assert page.run(under) == pytest.approx(before, abs=0.03)
    at = page.run("return player.world.column(4)")
    ActionChains(page.driver).drag_and_drop_by_offset(canvas, 90, 0).perform()
    page.settle()
    assert page.run("return player.world.column(4)") == pytest.approx(at + 90, abs=1)
    ActionChains(page.driver).double_click(canvas).perform()
    page.settle()
    assert page.run("return player.world.look.zoom") == 1


def test_another_robot_and_another_plot(page: Page) -> None:
    page.run("player.go(20)")
    page.settle()
    first = page.run("return byId('values').textContent")
    page.run("byId('agent').value = '1'; byId('agent').dispatchEvent(new Event('change'))")
    page.settle()
    assert page.run("return byId('values').textContent") != first
    legend = page.run("return [...byId('legend').children].map((item) => item.textContent)")
    assert [name for name in ("progress", "arrival", "total") if any(name in line for line in legend)]
    total = page.run("return player.episode.agents[1].values.reward.at(20)")
    terms = page.run("return Object.values(player.episode.agents[1].terms).map((table) => table.at(20))")
    assert sum(terms) == pytest.approx(total, abs=1e-5)
    page.run("byId('kind').value = 'goal_distance'; byId('kind').dispatchEvent(new Event('change'))")
    page.settle()
    assert page.run("return byId('legend').children.length") == 1


def test_another_episode_beside_it(page: Page) -> None:
    """Both play at the same time, the longer one to its end; moving one picture moves the other."""
    page.run("player.choose(1)")  # random; dash is beside it
    ends = page.run("return player.recording.episodes.map(({ count }) => count - 1)")
    assert ends[0] != ends[1]
    page.run("byId('beside').value = '0'; byId('beside').dispatchEvent(new Event('change'))")
    page.press("\ue010")  # end
    assert page.run("return [player.momentOf(player.other), player.momentOf(player.episode)]") == ends
    assert page.run("return byId('other-name').textContent").startswith("dash, level 0")
    page.run("player.go(20)")
    page.press("+")
    views = page.run("return [player.world, player.second].map(({ scale, limits, size }) => [scale, limits, size])")
    assert views[0] == views[1]
    x, y = page.run("return [...player.other.bodies.find((body) => body.name === 'robot_0').place.row(20)]")
    place = f"[player.second.column({x - 0.15}), player.second.row({y + 0.15})]"
    column, row = page.run(
        f"const b = byId('other').getBoundingClientRect(); const p = {place}; return [b.left + p[0], b.top + p[1]]"
    )
    assert tuple(page.picture()[round(row), round(column)].tolist()) == GREEN
    page.run("byId('beside').value = ''; byId('beside').dispatchEvent(new Event('change'))")
    assert page.run("return [byId('companion').offsetParent, player.timeline === player.episode]") == [None, True]


def test_a_click_into_the_plot_goes_there(page: Page) -> None:
    from selenium.webdriver.common.action_chains import ActionChains

    chart = page.driver.find_element("id", "chart")
    ActionChains(page.driver).move_to_element_with_offset(chart, 0, 0).click().perform()
    page.settle()
    middle = page.run("return (byId('chart').clientWidth / 2 - player.chart.plot.left) / player.chart.plot.width")
    wanted = middle * page.run("return player.episode.duration")
    assert page.moment == page.run(f"return player.episode.momentAt({wanted})")


def test_a_moment_looks_like_a_frame(driver: Any, tmp_path: Path) -> None:
    """On a canvas of 600 x 600 pixels the page shows what matplotlib draws, but for fonts and anti-aliasing."""
    scenario = {
        "world": {"height": 10, "width": 10},
        "robot": [
            {
                "kinematics": {"name": "acker", "wheelbase": 1.0},
                "shape": {"name": "rectangle", "length": 1.6, "width": 0.8},
                "state": [2, 2, 0.6],
                "goal": [8, 8, 0],
                "behavior": {"name": "dash"},
                "plot": {"show_goal": True, "show_trajectory": True, "show_text": True, "show_trail": True},
                "sensors": [{"name": "lidar2d", "number": 90, "range_max": 4}],
            }
        ],
        "obstacle": [
            {"shape": {"name": "polygon", "vertices": [[5, 2], [7, 2], [6.5, 4]]}},
            {"shape": {"name": "circle", "radius": 0.8}, "state": [3, 6]},
            {"shape": {"name": "linestring", "vertices": [[6, 6], [6, 9], [9, 9]]}},
        ],
    }
    with irsim_gym.load(scenario, record=True) as world:
        for _ in range(30):
            world.step()
        frame, replay = world.render(), world.save_html(tmp_path / "run.html")
    open_page(driver, replay, 1300, 900)
    page = Page(driver)
    page.run(
        "byId('world').style.cssText = 'position: fixed; left: 0; top: 0; width: 600px; height: 600px; z-index: 9'"
    )
    page.run("player.go(30)")
    page.settle()
    shown = page.picture()[:600, :600].astype(int)
    assert frame.shape == shown.shape
    off = np.abs(frame.astype(int) - shown).max(axis=2)
    assert off.mean() < 3.0
    assert (off > 60).mean() < 0.02
    assert (np.abs(frame.astype(int) - 255).max(axis=2) > 60).mean() > 0.05  # there is something to see
    assert page.problems() == []


def test_marks_look_like_those_of_a_frame(driver: Any, tmp_path: Path) -> None:
    """What a script drew is on the page at its moments, where and as large as matplotlib draws it."""
    scenario = {"world": {"height": 10, "width": 10}, "robot": [{"kinematics": {"name": "diff"}, "state": [5, 5, 0]}]}
    with irsim_gym.load(scenario, record=True) as world:
        world.draw.path([[1, 9], [3, 8], [5, 9]], "g--", width=3)
        frames = []
        for k in range(3):
            world.draw.points([[2 + 2 * k, 7], [3 + 2 * k, 7]], color="#ff0000", size=16, once=True)
            world.draw.points([[2 + 2 * k, 3]], color="#0000ff", marker="*", size=30, once=True)
            world.draw.points([[3 + 2 * k, 3]], marker="x", size=20, once=True)
            world.draw.polygon([[7, 1], [9, 1], [9, 2 + k]], fill="#00ff00", color="k", alpha=0.5, once=True)
            world.draw.text(3, 1 + 0.5 * k, "words", size=14)
            world.draw.arrows([[1, 5]], [[0.5 + k, 0]], once=True)
            world.draw.title(["one", None, "three"][k])
            frames.append(world.render())
            world.step()
        replay = world.save_html(tmp_path / "run.html")
    open_page(driver, replay, 1300, 900)
    page = Page(driver)
    page.run(
        "byId('world').style.cssText = 'position: fixed; left: 0; top: 0; width: 600px; height: 600px; z-index: 9'"
    )
    for k in (2, 0, 1):
        page.run(f"player.go({k})")
        page.settle()
        shown = page.picture()[:600, :600].astype(int)
        off = np.abs(frames[k].astype(int) - shown).max(axis=2)
        if folder := os.environ.get("IRSIM_GYM_PICTURES"):
            page.driver.save_screenshot(str(Path(folder) / f"marks-{k}.png"))
        assert off.mean() < 1.5
        assert (off > 60).mean() < 0.01
        assert page.colour(2 + 2 * k, 7) == RED
        assert page.colour(2 + 2 * k, 3) == BLUE
        assert page.colour(2 + 2 * ((k + 1) % 3), 7) != RED
    page.run("player.go(3)")
    page.settle()
    assert page.colour(6, 7) != RED
    marks = page.run("return player.episode.items.filter(({ rank }) => ['marks', 'words'].includes(rank)).length")
    assert marks == 1 + 3 + 3 * 5
    assert page.problems() == []


def test_a_new_mark_needs_no_javascript(driver: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A figure that the vocabulary adds to goals is on the page: an arrow whose tip is a metre and 30 points away."""
    known = vocabulary.goal
    reach, sides = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]]), np.array([[0.0, 9.0], [30.0, 0.0], [0.0, -9.0]])
    arrow = Shape((np.vstack([reach, reach[:1]]),), (np.vstack([sides, sides[:1]]),))

    def goal(view: GoalView) -> Iterator[Primitive]:
        place = np.array([[view.x, view.y, 0.5 * np.pi]])
        yield Figure("goals", view.style.goal_order, Pen(Ink("#ff0000")), arrow, place)
        yield from known(view)

    monkeypatch.setattr(vocabulary, "goal", goal)
    robot = {"kinematics": {"name": "diff"}, "state": [2, 2, 0], "goal": [5, 5, 0], "plot": {"show_goal": True}}
    with irsim_gym.load({"world": {"height": 10, "width": 10}, "robot": robot}, record=True) as world:
        world.step()
        replay = world.save_html(tmp_path / "run.html")
    open_page(driver, replay, 1200, 900)
    page = Page(driver)
    point = page.run("return player.world.point / player.world.scale")
    assert page.colour(5.0, 6.0 + 20 * point) == RED
    assert page.colour(5.0, 6.0 + 32 * point) == WHITE
    page.press("+")
    assert page.colour(5.0, 6.0 + 26 * point) == WHITE  # points are smaller where more pixels are a metre
    assert page.colour(5.0, 6.0 + 20 * point) == RED
    assert page.problems() == []


@pytest.mark.parametrize("size", [(1400, 900), (420, 860)])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_light_dark_wide_and_narrow(driver: Any, replay: Path, size: tuple[int, int], scheme: str) -> None:
    open_page(driver, replay, *size, scheme)
    page = Page(driver)
    page.run("player.go(25)")
    page.settle()
    picture = page.picture()
    assert picture.shape[:2] == size[::-1]
    corner = picture[picture.shape[0] // 12 if size[0] > 800 else 12, 3].mean()
    assert corner > 200 if scheme == "light" else corner < 60
    assert page.colour(4.0, 4.6) == RED
    assert page.run("return document.documentElement.scrollWidth") <= size[0]
    if folder := os.environ.get("IRSIM_GYM_PICTURES"):
        page.driver.save_screenshot(str(Path(folder) / f"replay-{scheme}-{size[0]}.png"))
    assert page.problems() == []


@pytest.mark.parametrize("size", [(375, 667), (360, 640), (667, 375), (640, 360)])
def test_a_phone(driver: Any, replay: Path, size: tuple[int, int]) -> None:
    """Nothing has to be moved sideways, the controls are on the screen, and fingers hit them: 44 pixels each way."""
    open_page(driver, replay, *size, mobile=True)
    page = Page(driver)
    page.run("player.go(25)")
    page.settle()
    assert page.run("return [innerWidth, document.documentElement.scrollWidth]") == [size[0], size[0]]
    page.run("document.querySelector('details').open = true")
    boxes = page.run("""
        const seen = [...document.querySelectorAll('*')].filter((part) => part.offsetParent);
        return seen.map((part) => {
          const { left, top, right, bottom } = part.getBoundingClientRect();
          const isControl = part.matches('button, select, summary, input[type=range], fieldset label, footer label');
          return [part.id || part.textContent.trim(), isControl, part.closest('footer') !== null,
            left, top, right, bottom];
        });
    """)
    controls = [box for box in boxes if box[1]]
    assert len(controls) > 15
    assert [(name, right - left) for name, _, _, left, _, right, _ in controls if right - left < 44] == []
    assert [(name, foot - top) for name, _, _, _, top, _, foot in controls if foot - top < 44] == []
    assert [name for name, _, _, left, _, right, _ in boxes if left < 0 or right > size[0] + 0.5] == []
    assert all(top >= 0 and foot <= size[1] + 0.5 for _, _, below, _, top, _, foot in boxes if below)
    top, width, height = page.run("const b = byId('world').getBoundingClientRect(); return [b.top, b.width, b.height]")
    footer = page.run("return document.querySelector('footer').getBoundingClientRect().top")
    assert top + height <= footer
    assert min(width, height) >= 0.6 * min(size)
    if folder := os.environ.get("IRSIM_GYM_PICTURES"):
        page.driver.save_screenshot(str(Path(folder) / f"replay-phone-{size[0]}.png"))
    assert page.problems() == []


def test_a_damaged_page_says_so(driver: Any, replay: Path, tmp_path: Path) -> None:
    text = replay.read_text(encoding="utf-8")
    begin = text.index('id="data">') + len('id="data">')
    damaged = tmp_path / "damaged.html"
    damaged.write_text(text[: begin + 40] + "AAAA" + text[begin + 60 :], encoding="utf-8")
    driver.get(damaged.as_uri())
    wait(driver, "return document.body.textContent.includes('cannot be played')")
    assert any(entry["level"] == "SEVERE" for entry in driver.get_log("browser"))
