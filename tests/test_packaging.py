"""The wheel and the sdist, installed where nothing else of ours is."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import pytest

import irsim_gym

ROOT = Path(__file__).parents[1]

MAKE_AN_ENV = """
import pathlib, sys
import irsim_gym
assert pathlib.Path(sys.prefix) in pathlib.Path(irsim_gym.__file__).parents, irsim_gym.__file__
env = irsim_gym.make("sparse_circles")
observation, info = env.reset(seed=1)
assert env.observation_space.contains(observation)
env.step(env.action_space.sample())
env.close()
"""


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the sdist and the wheel that is built from it."""
    folder = tmp_path_factory.mktemp("dist")
    _run(sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder), str(ROOT))
    return folder


@pytest.fixture(scope="module")
def environment(built: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A virtual environment with the wheel.

    Our dependencies come from the present environment through a path file. Such a file does not read the
    path files of the folder it names, so an editable installation of ours is not visible.
    """
    folder = tmp_path_factory.mktemp("installed")
    _run(sys.executable, "-m", "venv", "--without-pip", str(folder))
    python = _python(folder)
    (wheel,) = built.glob("*.whl")
    _run(sys.executable, "-m", "pip", "--python", str(python), "install", "--no-deps", "--no-index", str(wheel))
    place = _run(str(python), "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").strip()
    (Path(place) / "dependencies.pth").write_text(sysconfig.get_path("purelib"), encoding="utf-8")
    return folder


LEFT_OUT = (
    *("cluttered_room_images", "crossing", "crossing_10", "crowd_nav_scan", "dense_room_memory_robot"),
    *("drl_robot_navigation", "general_robot", "general_scan", "ice_channel", "jaxnav_four", "maze_robot"),
    *("crowd_mixed", "pss_social", "sort_boxes"),
)
"""Policies that the repository has and the wheel does not."""


def test_the_wheel_holds_what_runs(built: Path) -> None:
    (wheel,) = built.glob("*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    for source in (file for suffix in ("yaml", "png") for file in (ROOT / "configs").rglob(f"*.{suffix}")):
        assert f"irsim_gym/configs/{source.relative_to(ROOT / 'configs').as_posix()}" in names
    for source in (ROOT / "agents" / "hyperparameters").rglob("*.yaml"):
        assert f"irsim_gym/{source.relative_to(ROOT / 'agents').as_posix()}" in names
    for source in (ROOT / "agents" / "shelf").rglob("*.*"):
        is_left_out = source.stem in LEFT_OUT
        assert (f"irsim_gym/{source.relative_to(ROOT / 'agents').as_posix()}" in names) is not is_left_out
    for source in (ROOT / "irsim_gym" / "rendering" / "replay" / "page").iterdir():
        assert f"irsim_gym/rendering/replay/page/{source.name}" in names
    for source in (ROOT / "irsim_gym" / "robot" / "nodes").rglob("*"):
        is_none = source.is_dir() or source.suffix == ".pyc"
        assert is_none or f"irsim_gym/{source.relative_to(ROOT / 'irsim_gym').as_posix()}" in names
    assert {
        "irsim_gym/py.typed",
        "irsim_gym/simulator/readings/irsim_names.json",
        "irsim_gym/scenario/specs/keywords.json",
    } <= set(names)
    assert [name for name in names if name.endswith("licenses/LICENSE")]
    strangers = [name for name in names if not name.startswith(("irsim_gym/", "irsim_gym-"))]
    assert not strangers
    assert not [name for name in names if "__pycache__" in name]


def test_the_sdist_holds_what_builds_and_tests(built: Path) -> None:
    (sdist,) = built.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        names = {name.split("/", 1)[-1] for name in archive.getnames()}
    assert {
        "pyproject.toml",
        "LICENSE",
        "README.md",
        "DESIGN.md",
        "CHANGELOG.md",
        "CONTRIBUTING.md",
        "SECURITY.md",
        "CITATION.cff",
        "CODE_OF_CONDUCT.md",
    } <= names
    assert {"Makefile", "constraints.txt", "tests/test_packaging.py", "irsim_gym/py.typed"} <= names
    for folder in ("configs/scenarios", "configs/benchmarks"):
        assert {f"{folder}/{file.name}" for file in (ROOT / folder).glob("*.yaml")} <= names
    assert not [name for name in names if name.startswith(("runs/", ".venv"))]


@pytest.mark.parametrize(
    ("origin", "shown"),
    [
        ("https://github.com/me/irsim_gym.git", "https://raw.githubusercontent.com/me/irsim_gym/{commit}/docs/a.png"),
        ("git@github.com:me/irsim_gym.git", "https://raw.githubusercontent.com/me/irsim_gym/{commit}/docs/a.png"),
        ("https://example.org/me/irsim_gym", None),
        (None, None),
    ],
)
def test_an_index_shows_no_broken_links(origin: str | None, shown: str | None, tmp_path: Path) -> None:
    text = "![A robot](docs/a.png) [design](DESIGN.md#6) [web](https://a.b/c) [below](#more)\n"
    (tmp_path / "README.md").write_text(text, encoding="utf-8")
    git = ("git", "-C", str(tmp_path), "-c", "user.name=a", "-c", "user.email=a@b")
    _run(*git, "init", "-q")
    _run(*git, "add", ".")
    _run(*git, "commit", "-q", "-m", "a page")
    if origin is not None:
        _run(*git, "remote", "add", "origin", origin)
    commit = _run(*git, "rev-parse", "HEAD").strip()
    written = _build_hook().description(tmp_path)
    kept = "[web](https://a.b/c) [below](#more)\n"
    if shown is None:
        assert written == f" design {kept}"
    else:
        page = f"https://github.com/me/irsim_gym/blob/{commit}/DESIGN.md#6"
        assert written == f"![A robot]({shown.format(commit=commit)}) [design]({page}) {kept}"


def test_an_index_leads_to_the_repository(tmp_path: Path) -> None:
    hook = _build_hook()
    _run("git", "-C", str(tmp_path), "init", "-q")
    assert hook.addresses(tmp_path) == {}
    _run("git", "-C", str(tmp_path), "remote", "add", "origin", "https://github.com/me/irsim_gym.git")
    found = hook.addresses(tmp_path)
    assert found["Issues"] == "https://github.com/me/irsim_gym/issues"
    (tmp_path / "PKG-INFO").write_text(
        "Metadata-Version: 2.4\n" + "".join(f"Project-URL: {label}, {url}\n" for label, url in found.items()), "utf-8"
    )
    _run("git", "-C", str(tmp_path), "remote", "remove", "origin")
    assert hook.addresses(tmp_path) == found


def test_an_index_accepts_both(built: Path) -> None:
    _run(sys.executable, "-m", "twine", "check", "--strict", *map(str, built.iterdir()))


def test_the_wheel_stays_small(built: Path) -> None:
    """Half is certificates of levels, policies and pictures, which are compressed already."""
    (wheel,) = built.glob("*.whl")
    assert wheel.stat().st_size <= 3.4e6


@pytest.mark.slow
def test_a_bare_environment_needs_nothing_else(built: Path, tmp_path: Path) -> None:
    """With the dependencies that the wheel names, and nothing of the present environment: no PyTorch."""
    _run(sys.executable, "-m", "venv", str(tmp_path / "bare"))
    python = str(_python(tmp_path / "bare"))
    (wheel,) = built.glob("*.whl")
    constraints = str(ROOT / "constraints.txt")
    _run(python, "-m", "pip", "install", "--disable-pip-version-check", "-c", constraints, str(wheel), most_s=3000)
    assert "No broken requirements" in _run(python, "-m", "pip", "check")
    command = str(Path(python).parent / "irsim-gym")
    assert irsim_gym.__version__ in _run(command, "--version")
    _run(command, "new", "first.yaml", cwd=tmp_path)
    _run(command, "check", "first.yaml", cwd=tmp_path, most_s=600)
    _run(command, "evaluate", "cluttered_room", "cluttered_room", "--levels", "8", cwd=tmp_path, most_s=600)
    train = [command, "train", "first.yaml"]
    refused = subprocess.run(train, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert refused.returncode == 1
    assert 'pip install "irsim_gym[train]"' in refused.stderr


def test_wheel_and_sdist_describe_the_package_alike(built: Path) -> None:
    (wheel,), (sdist,) = built.glob("*.whl"), built.glob("*.tar.gz")
    with zipfile.ZipFile(wheel) as archive:
        metadata = next(name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        of_wheel = archive.read(metadata).decode("utf-8")
    with tarfile.open(sdist) as archive:
        info = next(name for name in archive.getnames() if name.endswith("/PKG-INFO"))
        stream = archive.extractfile(info)
        assert stream is not None
        of_sdist = stream.read().decode("utf-8")
    assert of_wheel.split("\n\n", 1)[1] == of_sdist.split("\n\n", 1)[1]
    assert not re.findall(r"\]\((?!https://|#)", of_wheel)
    first = (ROOT / "README.md").read_text(encoding="utf-8").split("```python\n")[1].split("```")[0]
    assert first in of_wheel


def test_every_dependency_has_a_lowest_version() -> None:
    """`make test-versions` tries them."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [*project["dependencies"], *(one for extra in project["optional-dependencies"].values() for one in extra)]
    others = [one for one in wanted if not one.startswith("irsim_gym[")]  # one extra that brings another
    assert [one for one in others if ">=" not in one and "==" not in one] == []


def test_the_installed_command_lists_scenarios(environment: Path, tmp_path: Path) -> None:
    command = _python(environment).parent / "irsim-gym"
    listed = _run(str(command), "list", cwd=tmp_path)
    for folder in ("configs/scenarios", "configs/benchmarks"):
        for file in (ROOT / folder).glob("*.yaml"):
            assert file.stem in listed


def test_the_installed_package_makes_an_env(environment: Path, tmp_path: Path) -> None:
    """Kernels run as plain Python here, because compiling them anew takes long and shows nothing about packaging."""
    _run(str(_python(environment)), "-c", MAKE_AN_ENV, cwd=tmp_path, NUMBA_DISABLE_JIT="1")


def test_the_installed_package_finds_its_hyperparameters(environment: Path, tmp_path: Path) -> None:
    code = (
        "from irsim_gym.training.settings.hyperparameters import load_hyperparameters as f; "
        "print(f('ppo', 'cluttered_room'))"
    )
    assert _run(str(_python(environment)), "-c", code, cwd=tmp_path)


def test_the_installed_package_has_its_shelf(environment: Path, tmp_path: Path) -> None:
    code = "import irsim_gym; print(irsim_gym.load_policy('cluttered_room').card.name)"
    assert _run(str(_python(environment)), "-c", code, cwd=tmp_path) == "cluttered_room\n"


def _build_hook() -> Any:
    spec = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _python(environment: Path) -> Path:
    return environment / ("Scripts" if os.name == "nt" else "bin") / "python"


def _run(*command: str, cwd: Path | None = None, most_s: float = 300, **variables: str) -> str:
    outside = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    result = subprocess.run(
        command, cwd=cwd, env=outside | variables, capture_output=True, text=True, check=False, timeout=most_s
    )
    assert result.returncode == 0, f"{' '.join(command)}\n{result.stdout}\n{result.stderr}"
    return result.stdout
