"""An exported policy, made once for all tests."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("onnx")
pytest.importorskip("onnxruntime")

from irsim_gym.robot.export import RobotExport, export_for_robot


@pytest.fixture(scope="session")
def exported(tmp_path_factory: pytest.TempPathFactory) -> RobotExport:
    return export_for_robot("cluttered_room", tmp_path_factory.mktemp("robot") / "cluttered_room", levels=20)


@pytest.fixture(scope="session")
def contract(exported: RobotExport) -> Path:
    return exported.folder / "contract.json"
