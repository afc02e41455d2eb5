"""Every page of the site in a real browser, without a server: light and dark, narrow and wide; and the search."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browser import browser
from test_replay_page import wait

ROOT = Path(__file__).parents[2]
SIZES = ((375, 700), (1280, 900))
KEPT = ("index", "start", "scenarios/index", "scenarios/circle_swap", "options/behavior", "lessons/first_scenario")
"""Pages of which IRSIM_GYM_PICTURES gets pictures."""
DARK, LIGHT = 70, 200


@pytest.fixture(scope="module")
def site() -> Path:
    """The folder of the site, as it stands now."""
    done = subprocess.run([sys.executable, "docs/build.py"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
    return ROOT / "build" / "site"


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with browser(tmp_path_factory.mktemp("profile")) as started:
        yield started


def test_every_page(site: Path, driver: Any) -> None:
    """No error on the console, nothing wider than the window, text for every picture, dark where that is asked for."""
    wrong = []
    for file in pages(site):
        name = file.relative_to(site).with_suffix("").as_posix()
        driver.get(file.as_uri())
        without = driver.execute_script("return [...document.images].filter((one) => !one.alt).map((one) => one.src)")
        wrong += [f"{name}: no alternative text: {one}" for one in without]
        broken = "(one) => one.complete && !one.naturalWidth"
        unloaded = driver.execute_script(f"return [...document.images].filter({broken}).map((one) => one.src)")
        wrong += [f"{name}: not shown: {one}" for one in unloaded]
        for width, height in SIZES:
            for scheme in ("light", "dark"):
                seen(driver, width, height, scheme)
                wide = driver.execute_script("return document.documentElement.scrollWidth")
                if wide > width:
                    wrong.append(f"{name}: {wide} pixels wide in a window of {width}")
                shade = brightness(driver)
                if shade > DARK if scheme == "dark" else shade < LIGHT:
                    wrong.append(f"{name}: {scheme}, but the page's brightness is {shade}")
                keep(driver, name, f"{scheme}-{width}")
        wrong += [f"{name}: {entry['message']}" for entry in driver.get_log("browser") if entry["level"] == "SEVERE"]
    assert wrong == []


def test_search_needs_no_server(site: Path, driver: Any) -> None:
    driver.get(f"{(site / 'search.html').as_uri()}?q=lidar2d")
    wait(driver, "return document.querySelectorAll('ul.search li a').length > 2")
    found = driver.execute_script("return [...document.querySelectorAll('ul.search li a')].map((one) => one.href)")
    assert any("options/sensor.html" in link for link in found)
    assert [entry for entry in driver.get_log("browser") if entry["level"] == "SEVERE"] == []


def pages(site: Path) -> list[Path]:
    return [file for file in sorted(site.rglob("*.html")) if "_static" not in file.parts]


def seen(driver: Any, width: int, height: int, scheme: str) -> None:
    screen = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})


def brightness(driver: Any) -> float:
    color = driver.execute_script("return getComputedStyle(document.body).backgroundColor")
    return sum(map(float, re.findall(r"[0-9.]+", color)[:3])) / 3


def keep(driver: Any, name: str, how: str) -> None:
    if (folder := os.environ.get("IRSIM_GYM_PICTURES")) and name in KEPT:
        driver.save_screenshot(str(Path(folder) / f"site-{name.replace('/', '-')}-{how}.png"))
