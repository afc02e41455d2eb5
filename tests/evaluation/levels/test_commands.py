"""The commands on one small file, and the page that describes them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import irsim_gym as ig
from irsim_gym.cli.app import app
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.levels.certificate import read_certificate
from irsim_gym.evaluation.levels.certificate_file import NUMBERS, WHOLE
from irsim_gym.scenario.reading.level_reading import read_levels
from irsim_gym.scenario.specs.level_set import ARRAYS
from irsim_gym.scenario.specs.library import configs_folder

PAGE = Path(__file__).parents[3] / "docs" / "levels.md"


def run(*words: str | Path) -> str:
    done = CliRunner().invoke(app, ["levels", *map(str, words)], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return done.output


def test_levels_are_drawn_certified_shown_and_played(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    scenario = (configs_folder() / "scenarios" / "cluttered_room.yaml").read_text(encoding="utf-8")
    (tmp_path / "room.yaml").write_text(scenario, encoding="utf-8")
    assert "8 levels of test, dev, hash" in run(
        "draw", "room.yaml", "--split", "test,dev", "--count", 4, "--out", "a.npz"
    )
    said = run("draw", "room.yaml", "--count", 6, "--out", "b.npz")
    levels = read_levels("b.npz")
    assert levels.about["scenario"] == "room.yaml"
    assert read_levels("a.npz").hashes()[:4].tolist() == levels.hashes()[:4].tolist()
    policies = "dash", "rvo:vxmax=1:vymax=0.5"
    assert said.split()[-1] in run("certify", "b.npz", *policies, "--count", 6)
    certificate = read_certificate(Path("b.certificate.npz"))
    assert (certificate.count, certificate.policies, certificate.agents) == (
        6,
        ("dash", "rvo:vxmax=1:vymax=0.5"),
        ("robot_0",),
    )
    env, drawn = ig.make("b.npz"), ig.make("room.yaml")
    np.testing.assert_array_equal(env.reset(seed=3)[0], drawn.reset(seed=3, options={"split": "test"})[0])
    (tmp_path / "room.yaml").unlink()
    with pytest.raises(IrsimGymError, match=r"room.yaml.*no such file"):
        ig.make("b.npz")


def test_the_page_names_all_arrays_and_runs() -> None:
    page = PAGE.read_text(encoding="utf-8")
    for name, array in ARRAYS.items():
        axes = re.escape(f"({', '.join(array.axes)})")
        row = rf"\| `{name}` \| {axes} \|.*{array.meaning[:30]}"
        assert re.search(row, page), name
    assert all(f"| `{name}` |" in page for name in (*WHOLE, *NUMBERS, "about"))


def test_the_examples_of_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    examples = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    assert len(examples) == 3
    for text in examples:
        exec(compile(text, str(PAGE), "exec"), {})
