"""The picture of evaluated ways: where obstacles are, and how ways ended."""

from __future__ import annotations

from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest
from hand_made import Body, box, disc, make_world, wall
from matplotlib.text import Text

from irsim_gym.rendering.figures.ways_density import Density
from irsim_gym.rendering.figures.ways_marks import DrawnWay, colour_of
from irsim_gym.rendering.figures.ways_plot import WaysPanel, draw_ways, plot_ways
from irsim_gym.rendering.looks.fonts import label
from irsim_gym.rendering.scene.scene import MapView
from irsim_gym.training.curves.learning_curve import draw_curves


def test_density_is_the_share_of_levels() -> None:
    world = make_world([Body(disc(1.0), (3.0, 3.0, 0.0)), Body(box(4.0, 2.0), (7.0, 8.0, 0.0))], lidar=False)
    density = Density(world.model.bounds)
    density.add(world.renderer().scene(0).fixed)
    world.move(0, 6.0, 3.0)
    density.add(world.renderer().scene(0).fixed)
    shares = density.shares()
    assert shares.shape == (240, 240)

    def at(x: float, y: float) -> float:
        return float(shares[int((10.0 - y) * 24.0), int(x * 24.0)])

    assert (at(3.0, 3.0), at(6.0, 3.0), at(7.0, 8.0), at(1.0, 9.0)) == (0.5, 0.5, 1.0, 0.0)
    area = shares.sum() / 24.0**2
    assert area == pytest.approx(np.pi + 8.0, rel=0.02)


def test_walls_and_maps_are_seen() -> None:
    world = make_world([Body(wall((1.0, 1.0), (9.0, 1.0)))], lidar=False)
    density = Density(world.model.bounds)
    occupied = np.zeros((10, 20), np.bool_)
    occupied[2, 16] = True  # from 2 to 3 m, and from 8 to 8.5 m
    density.add(world.renderer().scene(0).fixed, MapView((0.0, 0.0, 10.0, 10.0), occupied, "k", 1.0))
    shares = density.shares()
    assert shares[int(9.0 * 24), 120] > 0.4
    assert shares[int(1.75 * 24), int(2.5 * 24)] == 1.0
    assert shares[int(1.2 * 24), int(2.5 * 24)] == 0.0


def test_the_picture(tmp_path: Path) -> None:
    density = Density(np.array([0.0, 0.0, 8.0, 4.0]))
    density.add(())
    along = np.column_stack([np.linspace(1.0, 7.0, 30), np.full(30, 2.0)])
    nowhere = np.full(2, np.nan)
    ways = [DrawnWay(along, np.array([7.0, 2.0]), "success"), DrawnWay(along[:1], nowhere, "collision")]
    panels = [
        WaysPanel("one", "50.0 % arrive", ways, {"success": 1, "collision": 1}),
        WaysPanel("two", "none arrives", [DrawnWay(along, nowhere, "left_world")], {"left_world": 1}),
    ]
    files = [tmp_path / name for name in ("ways.png", "ways.svg", "ways.pdf")]
    draw_ways(files, panels, density, "a title", "a note")
    red, green, blue = np.moveaxis(iio.imread(files[0])[..., :3].astype(int), 2, 0)
    for coloured in (green - red > 50, (blue - green > 50) & (blue > red), (red - green > 100) & (red - blue > 100)):
        rows = np.flatnonzero(coloured)  # the way that arrived, the one that left, and the mark of the collision
        assert len(rows) > 40
    assert colour_of("success") != colour_of("collision") != colour_of("anything else")
    text = files[1].read_text()
    for words in ("a title", "a note", "50.0 % arrive", "success 1, collision 1", "left world 1", "start", "goal"):
        assert words in text
    assert files[2].read_bytes().startswith(b"%PDF")
    assert len(list(tmp_path.iterdir())) == 3


@pytest.mark.parametrize("bounds", [(0.0, 0.0, 8.0, 8.0), (0.0, 0.0, 16.0, 4.0), (0.0, 0.0, 3.0, 9.0)])
def test_words_stand_on_the_picture_and_apart(bounds: tuple[float, float, float, float], tmp_path: Path) -> None:
    """In a square world, a long one and a high one: no text is cut off, and none lies over another."""
    density = Density(np.array(bounds))
    density.add(())
    ways = [DrawnWay(np.array([[1.0, 1.0], [5.0, 1.0]]), np.array([6.0, 2.0]), "collision")]
    panel = WaysPanel("a policy", "0.0 % (0.0\N{EN DASH}3.7) arrive", ways, {"collision": 100})
    figure = plot_ways([panel, panel], density, "some_scenario: 100 test levels", "A note that is long. " * 9)
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    texts = [text for text in figure.findobj(Text) if text.get_text().strip() and text.get_visible()]
    boxes = [text.get_window_extent(renderer) for text in texts]
    assert len(texts) > 20
    canvas = figure.bbox
    for k, (seen, text) in enumerate(zip(boxes, texts, strict=True)):
        assert (canvas.contains(*seen.min), canvas.contains(*seen.max)) == (True, True), text
        assert not [other for other, over in zip(texts[:k], boxes[:k], strict=True) if seen.overlaps(over)], text


def test_names_that_look_like_formulas_are_text(tmp_path: Path) -> None:
    """Also where an odd formula would be an error, and in legends, whose entries may not begin with _."""
    density = Density(np.array([0.0, 0.0, 8.0, 4.0]))
    density.add(())
    name = "a $x^{$ b"
    figure = plot_ways([WaysPanel(name, "", [], {})], density, f"100 $ or 200 $ {name}", f"{name} $")
    figure.savefig(tmp_path / "ways.png")
    texts = {text.get_text(): text.get_parse_math() for text in figure.findobj(Text) if "$" in text.get_text()}
    assert texts[f"100 $ or 200 $ {name}"] is texts[name] is False
    curve = [{"training_seconds": 1.0, "success": 0.5, "levels": 10}]
    draw_curves(tmp_path / "curves.png", name, [{"run": run, "curve": curve} for run in (name, "_x")], "success")
    assert label("_x").endswith("_x")
    assert not label("_x").startswith("_")
