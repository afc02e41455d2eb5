"""The packages that ``irsim-gym export --node`` writes: files, names, manifests, launch files, and their code."""

from __future__ import annotations

import ast
import compileall
import configparser
import importlib.util
import os
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
import yaml
from conftest import package_of

from irsim_gym.errors import IrsimGymError
from irsim_gym.robot.export import FILES, RobotExport, export_for_robot
from irsim_gym.robot.nodes.package import package_files, package_name

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
NAME = "cluttered_room_driver"
SHARED = {"ROS.md", "package.xml", "setup.py"} | {f"{NAME}/{file}" for file in ("__init__.py", "driving.py", "node.py")}
WORDS = ("PACKAGE_VERSION", "CONTRACT_PERIOD", "SCANNER_", "NO_RETURN", "ROBOT_RADIUS", "SCAN_AGE")
OWN = {
    "ros1": {"CMakeLists.txt", "launch/drive.launch"},
    "ros2": {"setup.cfg", f"resource/{NAME}", "launch/drive_launch.py", "config/collision_monitor.yaml"},
}


@pytest.fixture(params=["ros1", "ros2"])
def package(request: pytest.FixtureRequest) -> Path:
    folder: Path = request.getfixturevalue(request.param)
    return folder


@pytest.mark.parametrize("node", ["ros1", "ros2"])
def test_the_files_of_a_package(exported: RobotExport, node: str) -> None:
    texts = package_files(exported.contract, node)
    assert set(texts) == SHARED | OWN[node]
    assert not set(texts) & set(FILES)
    for place, text in texts.items():
        assert not [word for word in ("policy_driver", "irsim_gym.robot", *WORDS) if word in text], place
        assert "\n\n\n\n" not in text
    assert len(texts[f"{NAME}/node.py"].splitlines()) <= 100


@pytest.mark.parametrize(
    ("policy", "name"),
    [
        ("cluttered_room", "cluttered_room_driver"),
        ("My Run-2__b", "my_run_2_b_driver"),
        ("2026/crossing", "policy_2026_crossing_driver"),
    ],
)
def test_a_package_has_a_name_that_ros_allows(policy: str, name: str) -> None:
    assert package_name(policy) == name


def test_another_node_is_refused(tmp_path: Path) -> None:
    with pytest.raises(IrsimGymError, match="--node: there is no 'ros3': choose ros1 or ros2"):
        export_for_robot("cluttered_room", tmp_path / "out", node="ros3")
    assert not (tmp_path / "out").exists()


def test_the_code_of_a_package_is_compiled(package: Path) -> None:
    assert compileall.compile_dir(package, quiet=1, force=True)


def test_the_code_of_ros_1_runs_on_python_3_8(ros1: Path) -> None:
    """That of ROS Noetic: its syntax, no types of later versions outside of annotations, no ``zip(strict=...)``."""
    files = [*ros1.glob("*.py"), *(ros1 / NAME).glob("*.py")]
    assert {"drive.py", "driving.py", "node.py"} <= {file.name for file in files}
    for file in files:
        tree = ast.parse(file.read_text(encoding="utf-8"), str(file), feature_version=(3, 8))
        has_functions = any(isinstance(node, ast.FunctionDef) for node in ast.walk(tree))
        future = [node for node in tree.body if isinstance(node, ast.ImportFrom) and node.module == "__future__"]
        assert future or not has_functions, file
        stated = [node.value for node in tree.body if isinstance(node, ast.Assign)]
        generic = [one for value in stated for one in ast.walk(value) if isinstance(one, ast.Subscript)]
        assert not [one for one in generic if ast.unparse(one.value) in {"dict", "list", "set", "tuple"}], file
        assert not [node for node in ast.walk(tree) if isinstance(node, ast.keyword) and node.arg == "strict"], file


def test_the_code_of_a_package_is_clean(package: Path) -> None:
    checks = [sys.executable, "-m", "ruff", "--quiet"]
    settings = ["--config", str(ROOT / "pyproject.toml"), "--no-cache"]
    for words in (["check", *settings], ["format", "--check", *settings]):
        done = subprocess.run([*checks[:3], *words, str(package)], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr


def test_the_types_of_a_package_fit(package: Path, tmp_path: Path) -> None:
    """ROS 2 has stand-ins with its types; what is imported from ROS 1 may be anything."""
    words = ["--strict", "--cache-dir", str(tmp_path), "--ignore-missing-imports", "--no-site-packages"]
    paths, scripts = dict(os.environ), [[str(file)] for file in (*package.glob("*.py"), *package.glob("launch/*.py"))]
    if (package / "launch" / "drive_launch.py").exists():
        paths["MYPYPATH"] = str(HERE / "ros2")
    for what in (["-p", NAME], *scripts):
        command = [sys.executable, "-m", "mypy", *words, "--python-version", "3.11", *what]
        done = subprocess.run(command, cwd=package, env=paths, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr


def test_the_manifests_name_the_package(package: Path, exported: RobotExport) -> None:
    manifest = ElementTree.parse(package / "package.xml").getroot()
    assert manifest.findtext("name") == NAME
    assert manifest.findtext("version") == exported.contract.irsim_gym
    needed = {element.text for element in manifest.findall("exec_depend")}
    assert {"sensor_msgs", "nav_msgs", "geometry_msgs", "python3-numpy"} <= needed


def test_a_package_is_installed_with_its_node_and_policy(ros2: Path, tmp_path: Path) -> None:
    """By setuptools, as colcon does it."""
    command = [
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "--no-deps",
        "--no-build-isolation",
        "-w",
        str(tmp_path),
        str(ros2),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (wheel,) = tmp_path.glob("*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert {f"{NAME}/{file}" for file in ("__init__.py", "driving.py", "node.py")} <= set(names)
    shared = {name.split("/data/share/")[1] for name in names if "/data/share/" in name}
    own = {"package.xml", "launch/drive_launch.py", "config/collision_monitor.yaml"}
    own |= {"contract.json", "contract.schema.json", "policy.onnx"}
    drivers = {file.name for file in ros2.glob("*.py")} - {"setup.py"}
    assert "drive.py" in drivers
    assert shared == {f"{NAME}/{file}" for file in own | drivers} | {f"ament_index/resource_index/packages/{NAME}"}
    (entries,) = (name for name in names if name.endswith("entry_points.txt"))
    assert f"node = {NAME}.node:main" in zipfile.ZipFile(wheel).read(entries).decode()
    scripts = configparser.ConfigParser(interpolation=None)
    scripts.read(ros2 / "setup.cfg")
    assert scripts["develop"]["script_dir"] == scripts["install"]["install_scripts"] == f"$base/lib/{NAME}"


def test_the_collision_monitor_fits_the_robot(ros2: Path, exported: RobotExport) -> None:
    told = yaml.safe_load((ros2 / "config" / "collision_monitor.yaml").read_text(encoding="utf-8"))
    found = told["collision_monitor"]["ros__parameters"]
    assert found["robot"]["radius"] == pytest.approx(exported.contract.robot.radius)
    assert found["source_timeout"] == pytest.approx(exported.contract.stop.scan_age)
    assert (found["cmd_vel_in_topic"], found["cmd_vel_out_topic"]) == ("cmd_vel_raw", "cmd_vel")
    for name in (*found["polygons"], *found["observation_sources"]):
        assert name in found


def test_the_launch_file_puts_the_monitor_behind_the_driver(ros2: Path, stand_ins: None) -> None:
    spec = importlib.util.spec_from_file_location("drive_launch", ros2 / "launch" / "drive_launch.py")
    assert spec is not None
    assert spec.loader is not None
    module: Any = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    *arguments, driver, monitor, manager = module.generate_launch_description().entities
    defaults = {one.name: one.default_value for one in arguments}
    assert (defaults["scanner_yaw"], defaults["no_return"], defaults["speed_share"]) == ("0.0", "inf", "1.0")
    assert driver.remappings["cmd_vel"] == "cmd_vel_raw"
    assert monitor.parameters[0].parts[1:] == ["config", "collision_monitor.yaml"]
    assert monitor.parameters[1]["enable_stamped_cmd_vel"].value.name == "stamped"
    assert set(manager.parameters[0]["node_names"]) == {driver.name, monitor.name}
    assert {one.value.name for one in driver.parameters[0].values()} == set(driver.parameters[0])
    assert set(driver.parameters[0]) <= set(defaults)


def test_a_scanner_that_is_mounted_turned_is_the_default(exported: RobotExport, tmp_path: Path) -> None:
    assert exported.contract.scan is not None
    scan = exported.contract.scan.model_copy(update={"mount": (0.1, 0.0, 1.5), "no_return": "zero"})
    turned = RobotExport(exported.contract.model_copy(update={"scan": scan}), 1, 0.0, 1, exported.folder)
    launch = (package_of(turned, "ros1", tmp_path / "turned") / "launch" / "drive.launch").read_text(encoding="utf-8")
    found = {one.attrib["name"]: one.attrib["default"] for one in ElementTree.fromstring(launch).findall("arg")}
    assert [found[f"scanner_{part}"] for part in ("x", "y", "yaw")] == ["0.1", "0.0", "1.5"]
    assert (found["no_return"], found["period"]) == ("zero", "0.1")
