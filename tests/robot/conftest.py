"""An exported policy, made once for all tests."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("onnx")
pytest.importorskip("onnxruntime")

from irsim_gym.evaluation.protocol.tables import write_text
from irsim_gym.robot.export import RobotExport, export_for_robot
from irsim_gym.robot.nodes.package import package_files


@pytest.fixture(scope="session")
def exported(tmp_path_factory: pytest.TempPathFactory) -> RobotExport:
    return export_for_robot("cluttered_room", tmp_path_factory.mktemp("robot") / "cluttered_room", levels=20)


@pytest.fixture(scope="session")
def contract(exported: RobotExport) -> Path:
    return exported.folder / "contract.json"


def package_of(exported: RobotExport, node: str, folder: Path) -> Path:
    """Return a copy of an export as a package of ROS."""
    shutil.copytree(exported.folder, folder)
    for place, text in package_files(exported.contract, node).items():
        write_text(folder / place, text)
    return folder


@pytest.fixture(scope="session")
def ros2(exported: RobotExport, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return package_of(exported, "ros2", tmp_path_factory.mktemp("ros2") / "package")


@pytest.fixture(scope="session")
def ros1(exported: RobotExport, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return package_of(exported, "ros1", tmp_path_factory.mktemp("ros1") / "package")


@pytest.fixture
def stand_ins(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Let modules of ROS 2 be found, and forget them and who imports them afterwards."""
    before = set(sys.modules)
    monkeypatch.syspath_prepend(Path(__file__).with_name("ros2"))
    yield
    for name in set(sys.modules) - before:
        del sys.modules[name]
