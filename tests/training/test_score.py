import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from irsim_gym.rendering.looks.fonts import label
from irsim_gym.training.curves.learning_curve import draw_curve, draw_curves
from irsim_gym.training.curves.score import reached, read_curve
from irsim_gym.training.settings.run import Run


def point(seconds: float, success: float) -> dict[str, float]:
    return {
        "steps": 1000 * seconds,
        "training_seconds": seconds,
        "success": success,
        "success_low": success - 0.01,
        "success_high": success + 0.01,
        "collision": 1.0 - success,
    }


def test_a_mark_counts_from_when_it_holds_to_the_end() -> None:
    curve = [point(1, 0.5), point(2, 0.96), point(3, 0.94), point(4, 0.95), point(5, 0.97)]
    found = reached(curve, 0.95)
    assert found is not None
    assert found["training_seconds"] == 4
    assert reached(curve, 0.98) is None
    assert reached([], 0.5) is None


def test_curve_is_drawn_without_a_display(tmp_path: Path) -> None:
    draw_curve(tmp_path / "curve.png", [point(1, 0.4), point(8, 0.98)], "cluttered_room, PPO, seed 3")
    picture = imread(tmp_path / "curve.png")
    assert picture.ndim == 3
    assert np.ptp(picture[..., 0]) > 0.5


def test_names_that_look_like_formulas_are_text(tmp_path: Path) -> None:
    """Also where an odd formula would be an error, and in legends, whose entries may not begin with _."""
    curve = [{"training_seconds": 1.0, "success": 0.5, "levels": 10}]
    name = "a $x^{$ b"
    draw_curves(tmp_path / "curves.png", name, [{"run": run, "curve": curve} for run in (name, "_x")], "success")
    assert (tmp_path / "curves.png").is_file()
    assert label("_x").endswith("_x")
    assert not label("_x").startswith("_")


@pytest.mark.parametrize("content", ["[]", "null", '{"points": null}', '{"points": [3]}', '{"points": [{"steps": 1}]}'])
def test_a_curve_of_another_form_has_no_scores(content: str, tmp_path: Path) -> None:
    run = Run(tmp_path)
    run.curve.write_text(content)
    assert read_curve(run) == []


def test_a_curve_is_read(tmp_path: Path) -> None:
    point = {"steps": 64, "training_seconds": 1.5, "cpu_seconds": 1.0, "levels": 4, "success": 0.5}
    Run(tmp_path).curve.write_text(json.dumps({"points": [point]}))
    assert read_curve(Run(tmp_path)) == [point]
