"""Images of bodies lie where the bodies are, and fog where nobody has looked."""

from __future__ import annotations

import importlib.util
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import irsim_gym
from irsim_gym import compile
from irsim_gym.base.arraytypes import Bytes
from irsim_gym.errors import IrsimGymError, ScenarioError
from irsim_gym.live.world import World, load
from irsim_gym.rendering import Renderer
from irsim_gym.rendering.looks.images import LONGEST_SIDE, load_image
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.specs import library
from irsim_gym.scenario.specs.image_files import DEFAULT_CAR

RED, LIME, BLUE, GOLD, WHITE = (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 215, 0), (255, 255, 255)
FOG = (195, 202, 211)
CAR: dict[str, Any] = {
    "kinematics": {"name": "acker"},
    "shape": {"name": "rectangle", "length": 2.0, "width": 1.0, "wheelbase": 1.2},
}


@pytest.fixture
def quarters(tmp_path: Path) -> Path:
    """A picture whose quarters are red (front left), lime (front right), blue (rear left) and gold (rear right)."""
    pixels = np.zeros((40, 80, 3), np.uint8)
    pixels[:20, 40:], pixels[20:, 40:], pixels[:20, :40], pixels[20:, :40] = RED, LIME, BLUE, GOLD
    Image.fromarray(pixels).save(tmp_path / "quarters.png")
    return tmp_path / "quarters.png"


def world_with(folder: Path, text: str) -> World:
    file = folder / "world.yaml"
    file.write_text(text)
    return load(file)


def colour_at(world: World, frame: Bytes, x: float, y: float) -> tuple[int, ...]:
    column, row = world._camera._ready().layout.column_row(x, y)
    return tuple(int(level) for level in frame[int(row), int(column)])


BOX = "shape: {name: rectangle, length: 4, width: 2}, description: quarters.png"


@pytest.mark.parametrize("heading", [0.0, 0.5 * np.pi, 2.0, -0.7])
@pytest.mark.parametrize("section", ["robot", "obstacle"])
def test_an_image_lies_over_the_footprint_and_turns_with_the_body(quarters: Path, heading: float, section: str) -> None:
    drive = "kinematics: {name: diff}, plot: {show_arrow: false}, " if section == "robot" else ""
    with world_with(quarters.parent, f"{section}: {{{drive}{BOX}, state: [5, 5, {heading}]}}") as world:
        frame = world.render()
        for (ahead, aside), colour in {
            (1.7, 0.8): RED,
            (1.7, -0.8): LIME,
            (-1.7, 0.8): BLUE,
            (-1.7, -0.8): GOLD,
            (0.2, 0.2): RED,
            (2.2, 0.0): WHITE,
            (0.0, 1.2): WHITE,
        }.items():
            x = 5.0 + ahead * np.cos(heading) - aside * np.sin(heading)
            y = 5.0 + ahead * np.sin(heading) + aside * np.cos(heading)
            assert np.allclose(colour_at(world, frame, x, y), colour, atol=12), (ahead, aside)


def test_it_is_the_same_in_files(quarters: Path) -> None:
    plot = "world: {plot: {saved_figure: {bbox_inches: standard}}}\n"
    with world_with(quarters.parent, f"{plot}obstacle: {{{BOX}, state: [5, 5, 0.4]}}") as world:
        frame = world.render()
        with Image.open(world.save_figure(quarters.parent / "figure.png")) as saved:
            off = np.abs(np.asarray(saved.convert("RGB")).astype(int) - frame)
        assert (off.max(axis=2) > 30).mean() < 0.006  # edges of pixels that are enlarged
        assert "<image" in world.save_figure(quarters.parent / "figure.svg").read_text()


def test_the_rectangle_around_a_round_body_is_covered_where_the_body_is_off_its_centre(quarters: Path) -> None:
    circle = "{shape: {name: circle, radius: 1, center: [2, 0]}, state: [4, 5, 0], description: quarters.png}"
    with world_with(quarters.parent, f"obstacle: {circle}") as world:
        frame = world.render()
        assert np.allclose(colour_at(world, frame, 6.8, 5.8), RED, atol=12)
        assert np.allclose(colour_at(world, frame, 5.2, 4.2), GOLD, atol=12)
        assert np.allclose(colour_at(world, frame, 4.9, 5.0), WHITE, atol=12)


def test_opacity_and_layers_hold_for_images(quarters: Path) -> None:
    text = f"""
robot: {{kinematics: {{name: diff}}, {BOX}, state: [5, 5, 0], unobstructed: true, plot: {{obj_alpha: 0.5}}}}
obstacle: {{shape: {{name: circle, radius: 0.4}}, state: [6, 5.5, 0], color: black, plot: {{obj_zorder: %d}}}}
"""
    for layer, colour in ((1, (127, 0, 0)), (4, (0, 0, 0))):
        with world_with(quarters.parent, text % layer) as world:
            frame = world.render()
            assert np.allclose(colour_at(world, frame, 6.0, 5.5), colour, atol=12)
            assert np.allclose(colour_at(world, frame, 6.7, 5.7), (255, 127, 127), atol=12)


def test_a_still_body_that_is_turned_by_hand_is_drawn_anew(quarters: Path) -> None:
    """A disc has the same outline at any heading."""
    circle = "{shape: {name: circle, radius: 1}, state: [5, 5, 0], description: quarters.png}"
    with world_with(quarters.parent, f"obstacle: {circle}") as world:
        assert np.allclose(colour_at(world, world.render(), 5.5, 5.5), RED, atol=12)
        world.obstacle_list[0].set_state([5, 5, np.pi])
        assert np.allclose(colour_at(world, world.render(), 5.5, 5.5), GOLD, atol=12)


def test_images_beyond_the_frame_and_tiny_ones(quarters: Path) -> None:
    text = f"obstacle:\n  - {{{BOX}, state: [9.5, 5, 0]}}\n  - {{{BOX}, state: [50, 50, 0]}}\n"
    tiny = "  - {shape: {name: circle, radius: 0.001}, state: [2, 2, 0], description: quarters.png}\n"
    with world_with(quarters.parent, text + tiny) as world:
        frame = world.render()
        assert np.allclose(colour_at(world, frame, 9.8, 5.5), RED, atol=12)
        assert colour_at(world, frame, 5.0, 5.0) == WHITE


def test_ones_own_file_wins_over_a_shipped_one(quarters: Path) -> None:
    shutil.copy(quarters, quarters.parent / "car_blue.png")
    with world_with(quarters.parent, f"obstacle: {{{BOX.replace('quarters', 'car_blue')}, state: [5, 5, 0]}}") as world:
        assert np.allclose(colour_at(world, world.render(), 6.0, 5.5), RED, atol=12)


@pytest.mark.parametrize(
    ("entry", "image"),
    [
        ({}, DEFAULT_CAR),
        ({"description": "car_red.png", "color": "blue"}, "car_red.png"),
        ({"color": "blue"}, None),
        ({"plot": {"obj_color": "blue"}}, None),
        ({"plot": {"obj_linestyle": "--"}}, None),
        ({"plot": {"obj_linewidth": 2}}, None),
        ({"plot": {"obj_alpha": 0.5}}, DEFAULT_CAR),
        ({"shape": {"name": "circle", "radius": 0.5, "wheelbase": 0.4}}, None),
        ({"kinematics": {"name": "diff"}, "shape": {"name": "rectangle"}}, None),
    ],
)
def test_cars_whose_look_is_not_given_have_an_image(entry: dict[str, Any], image: str | None) -> None:
    assert load_scenario({"robot": {**CAR, **entry}}).bodies[0].description == image
    body = load_scenario({"obstacle": {**CAR, **entry}}).bodies[0]
    assert body.description == entry.get("description")


def test_an_image_shows_where_it_heads_by_itself() -> None:
    def marks(**plot: Any) -> int:
        world = irsim_gym.load({"robot": {**CAR, "state": [5, 5, 0, 0], "plot": plot}})
        return len(world._camera._ready().scene().moving[0].heading)

    assert marks() == 0
    assert marks(show_arrow=True) == 4
    assert marks(show_arrow=True, arrow_length=1.0) == 7


def test_shipped_images_are_drawn_by_their_script() -> None:
    folder = library.configs_folder() / "images"
    spec = importlib.util.spec_from_file_location("draw_images", folder / "draw_images.py")
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    drawn = script.draw_all()
    assert set(drawn) == set(library.assets("images"))
    for name, image in drawn.items():
        pixels = load_image(library.assets("images")[name]).astype(int)
        assert np.abs(pixels - np.asarray(script.paletted(image).convert("RGBA"))).mean() < 1.0, name
        shown, whole = (seen[..., :3] * (seen[..., 3:] / 255.0) for seen in (pixels, np.asarray(image)))
        assert np.abs(shown - whole).max() < 9.0, name
        assert library.assets("images")[name].stat().st_size < 6_000
        assert (pixels[..., 3] > 200).mean() > 0.7, "most of the rectangle is covered"
        assert (pixels[[0, 0, -1, -1], [0, -1, 0, -1], 3] == 0).all(), "the corners are clear"


def test_large_images_are_reduced_and_read_once(tmp_path: Path) -> None:
    Image.new("L", (2000, 1000), 255).save(tmp_path / "large.jpg")
    pixels = load_image(tmp_path / "large.jpg")
    assert pixels.shape == (LONGEST_SIDE // 2, LONGEST_SIDE, 4)
    assert load_image(tmp_path / "large.jpg") is pixels
    with pytest.raises(IrsimGymError, match=r"gone\.png is no image: no such file"):
        load_image(tmp_path / "gone.png")


def test_a_file_that_is_no_image_is_told_with_its_line(tmp_path: Path) -> None:
    (tmp_path / "broken.png").write_bytes(b"not an image")
    with pytest.raises(ScenarioError) as caught:
        world_with(tmp_path, "robot:\n  description: broken.png\n")
    assert [(problem.line, problem.message) for problem in caught.value.problems] == [
        (2, "'broken.png' cannot be read as an image")
    ]


FOGGY: dict[str, Any] = {
    "world": {"fog_map": True},
    "robot": {
        "kinematics": {"name": "diff"},
        "state": [3, 5, 0],
        "sensors": [{"name": "lidar2d", "number": 200, "angle_range": 6.2831, "range_max": 2}],
        "plot": {"show_sensor": False},
    },
}


def test_fog_lies_where_nobody_has_looked_until_the_next_episode() -> None:
    with load(FOGGY) as world:
        for _ in range(20):
            world.step([1.0, 0.0])
        frame = world.render()
        assert world.simulation.state.pose[0, 0, 0] == pytest.approx(5.0)
        for x in (1.5, 3.0, 5.5, 6.7):
            assert colour_at(world, frame, x, 5.5) == WHITE, "seen on the way"
        for x, y in ((0.3, 5.0), (7.5, 5.0), (5.0, 7.6), (9.5, 9.5)):
            assert colour_at(world, frame, x, y) == FOG
        explored = world.simulation.explored
        assert explored is not None
        before = explored.copy()
        world.render()
        assert np.array_equal(explored, before), "drawing explores nothing"
        world.reset()
        assert colour_at(world, world.render(), 6.7, 5.5) == FOG


def test_each_world_has_its_own_fog_and_keeps_it_between_frames() -> None:
    simulation = compile(load_scenario(FOGGY), n_worlds=2)
    simulation.reset(seed=0)
    parts = simulation.scenario, simulation.model, simulation.state, simulation.sensors
    explored = np.zeros((2, 100, 100), np.bool_)
    renderer = Renderer(*parts, explored=explored)
    column, row = (int(place) for place in renderer.layout.column_row(3.3, 6.3))
    explored[1, 28:40, 58:70] = True
    assert [tuple(renderer.frame(w)[row, column]) for w in (0, 1)] == [FOG, WHITE]
    fogs = [renderer.scene(1).fog for _ in range(2)]
    assert fogs[0] is fogs[1]
    explored[0] = True
    assert tuple(renderer.frame(0)[row, column]) == WHITE
    assert Renderer(*parts).scene().fog is None


def test_fog_covers_still_bodies_and_the_map_but_neither_goals_nor_robots() -> None:
    block = {"shape": {"name": "rectangle"}, "state": [8, 5, 0]}
    cells = {"name": "array", "cells": [[False, True], [False, False]]}
    scenario = {**FOGGY, "obstacle": block, "world": {"fog_map": True, "obstacle_map": cells}}
    scenario["robot"] = {
        **FOGGY["robot"],
        "state": [3, 4, 0],
        "goal": [8, 2],
        "goal_threshold": 0.5,
        "plot": {"show_goal": True},
    }
    with load(scenario) as world:
        frame = world.render()
        for x, y in ((8.0, 5.0), (1.0, 9.0)):
            assert colour_at(world, frame, x, y) == FOG
        assert colour_at(world, frame, 7.7, 1.9) not in (FOG, WHITE)
        assert colour_at(world, frame, 2.88, 4.0) not in (FOG, WHITE)
