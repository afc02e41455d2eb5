"""The page of an arena in a real browser: tables, the matrix of levels, and replays side by side."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browser import browser
from test_replay_page import Page, wait

import irsim_gym
from irsim_gym.evaluation.arena.contest import Arena

ROOM = {
    "world": {"height": 4, "width": 6, "step_time": 0.25},
    "robot": [
        {
            "kinematics": {"name": "diff"},
            "shape": {"name": "circle", "radius": 0.2},
            "state": [1, y, 0],
            "goal": [5, y, 0],
            "goal_threshold": 0.2,
        }
        for y in (1, 3)
    ],
    "obstacle": [
        {
            "shape": {"name": "circle", "radius": 0.4},
            "distribution": {"name": "random", "range_low": [2.5, 0.5, 0], "range_high": [3.5, 3.5, 0]},
        }
    ],
    "task": {"name": "navigation", "max_steps": 40},
}
LEVELS = 60


@pytest.fixture(scope="module")
def arena(tmp_path_factory: pytest.TempPathFactory) -> Arena:
    return irsim_gym.arena(ROOM, ["dash", "random"], tmp_path_factory.mktemp("arena"), levels=LEVELS, team=True)


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with browser(tmp_path_factory.mktemp("profile")) as started:
        yield started


def opened(driver: Any, arena: Arena, width: int, height: int, scheme: str = "light", *, mobile: bool = False) -> Page:
    screen = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": mobile}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
    driver.get("about:blank")
    driver.get(arena.page.as_uri())
    wait(driver, "return Boolean(window.arena)")
    page = Page(driver)
    page.settle()
    return page


def cells(page: Page, section: str) -> list[list[str]]:
    return list(
        page.run(
            f"return [...document.querySelectorAll('#{section} tbody tr')].map((row) => "
            "[...row.children].map((cell) => cell.firstChild.textContent))"
        )
    )


def test_figures_and_levels(driver: Any, arena: Arena) -> None:
    """Tables say what the results say; a click on a failed level plays it beside one that solved it."""
    page = opened(driver, arena, 1200, 900)
    first = arena.standings.summaries[0]
    assert cells(page, "figures")[0][:2] == ["dash", f"{100 * first.cooperative_success.value:.1f}"]
    for _ in range(2):
        page.run("document.querySelector('#figures thead button').click()")
    assert [row[0] for row in cells(page, "figures")] == ["random", "dash"]  # the worst first
    (pair,) = arena.standings.pairs
    assert cells(page, "pairs")[0][2] == f"+{100 * pair.success.value:.1f}"

    solved = {row.level for row in arena.rows["dash"] if row.is_success}
    failed = [row.level for row in arena.rows["random"] if not row.is_success and row.level in solved]
    page.run("byId('filter').value = '1'; byId('filter').dispatchEvent(new Event('change'))")
    count = sum(not row.is_success for row in arena.rows["random"])
    assert page.run("return byId('count').textContent") == f"{count} of {LEVELS} levels"
    level = page.run(
        "const { shown, recorded, outcomes } = arena.matrix;"
        "return shown.find((level) => recorded.has(`1 ${level}`) && outcomes[0][level] === 0)"
    )
    assert level in failed
    click_on(page, level, 1)
    wait(driver, "return arena.player.isOpen")
    assert page.run("return [arena.player.episode.details.policy, arena.player.other.details.policy]") == [
        "random",
        "dash",
    ]
    assert page.run("return byId('other-name').textContent").startswith(f"dash, level {level}: ")
    wait(driver, "return arena.player.moment > 2")  # it plays by itself
    page.press("\ue00c")  # escape
    wait(driver, "return byId('replay').hidden && !arena.player.isPlaying")
    assert page.run("return byId('chosen').querySelector('h3').textContent") == f"Level {level}"
    page.press("\ue014")  # the matrix still has the keyboard: the next level to the right
    place = page.run(f"return arena.matrix.shown.indexOf({level})")
    assert page.run("return arena.matrix.shown.indexOf(arena.matrix.chosen)") == place + 1
    assert page.problems() == []


def click_on(page: Page, level: int, policy: int) -> None:
    from selenium.webdriver.common.action_chains import ActionChains

    page.run("byId('matrix').scrollIntoView()")
    column, row, width, height = page.run(
        f"const {{ matrix }} = arena, place = matrix.shown.indexOf({level});"
        "const block = Math.floor(place / matrix.columns), box = matrix.canvas.getBoundingClientRect();"
        "const column = matrix.left + (place % matrix.columns + 0.5) * matrix.pitch;"
        f"return [column, matrix.top(block, {policy}) + 5, box.width, box.height]"
    )
    canvas = page.driver.find_element("id", "matrix")
    ActionChains(page.driver).move_to_element_with_offset(
        canvas, column - width / 2, row - height / 2
    ).click().perform()
    page.settle()


@pytest.mark.parametrize("size", [(1400, 900), (375, 667)])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_light_dark_wide_and_narrow(driver: Any, arena: Arena, size: tuple[int, int], scheme: str) -> None:
    """Nothing has to be moved sideways, but tables within their frames."""
    page = opened(driver, arena, *size, scheme, mobile=size[0] < 500)
    assert page.run("return document.documentElement.scrollWidth") <= size[0]
    corner = page.picture()[-2, 2].mean()
    assert corner > 200 if scheme == "light" else corner < 60
    keep(page, f"arena-{scheme}-{size[0]}")
    page.run("arena.go(...Object.values(arena.data.replays[0]).slice(0, 2).reverse(), null)")
    wait(driver, "return arena.player.isOpen")
    page.settle()
    assert page.run("return document.documentElement.scrollWidth") <= size[0]
    assert (
        page.run(
            "const b = byId('close').getBoundingClientRect(); return [b.left >= 0, b.right <= innerWidth, b.top >= 0]"
        )
        == [True] * 3
    )
    keep(page, f"arena-replay-{scheme}-{size[0]}")
    assert page.problems() == []


def test_long_names_on_a_phone(driver: Any, tmp_path: Path) -> None:
    """Nothing is wider than the screen, and the ends of names, in which they differ, can be read."""
    names = {f"warehouse-ppo-steps=1500000-{seed}": kind for seed, kind in enumerate(("dash", "random"))}
    page = opened(driver, irsim_gym.arena(ROOM, names, tmp_path / "arena", levels=20), 390, 844, mobile=True)
    assert page.run("return [innerWidth, document.documentElement.scrollWidth]") == [390, 390]
    heads = page.run(
        "return [...document.querySelectorAll('.wide tbody th')].map((e) => [e.clientWidth, e.scrollWidth])"
    )
    assert len(heads) >= 4
    assert all(inside >= whole for inside, whole in heads)
    keep(page, "arena-long-names")
    assert page.problems() == []


def keep(page: Page, name: str) -> None:
    if folder := os.environ.get("IRSIM_GYM_PICTURES"):
        page.driver.save_screenshot(str(Path(folder) / f"{name}.png"))
