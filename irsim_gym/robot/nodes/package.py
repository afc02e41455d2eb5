"""A ROS package around an exported policy: its node, driver, launch file and manifests."""

import re
from pathlib import Path

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.robot.contract import RobotContract

HERE = Path(__file__).parent
OWN = "policy_driver"
"""Stands for the name of the package in the files."""
SHARED = {"../drive.py": f"{OWN}/drive.py", "driving.py": f"{OWN}/driving.py"}
FILES = {
    "ros1": {
        "node.py": f"{OWN}/node.py",
        "package.xml": "package.xml",
        "setup.py.txt": "setup.py",
        "CMakeLists.txt": "CMakeLists.txt",
        "drive.launch": "launch/drive.launch",
    },
    "ros2": {
        "node.py": f"{OWN}/node.py",
        "package.xml": "package.xml",
        "setup.py.txt": "setup.py",
        "setup.cfg": "setup.cfg",
        "drive_launch.py.txt": "launch/drive_launch.py",
        "collision_monitor.yaml": "config/collision_monitor.yaml",
    },
}
"""Files of the package, by what they are written from."""


def check_node(node: str | None) -> None:
    """Raise an IrsimGymError if there is no package for a node."""
    if node is not None and node not in FILES:
        raise IrsimGymError(f"--node: there is no '{node}': choose {' or '.join(FILES)}")


def package_name(policy: str) -> str:
    """Return the name of a policy's ROS package: small letters, digits and single underscores, a letter first."""
    words = re.sub(r"[^a-z0-9]+", "_", policy.lower()).strip("_")
    return f"{words}_driver" if words[:1].isalpha() else f"policy_{words}_driver"


def package_files(contract: RobotContract, node: str) -> dict[str, str]:
    """Return the texts of a ROS package by their places in it; contract.json and policy.onnx come beside them.

    Args:
        contract: The contract of the export.
        node: ``ros1`` or ``ros2``.
    """
    name, scan = package_name(contract.policy), contract.scan
    words = {
        OWN: name,
        "irsim_gym.robot.nodes": name,
        "irsim_gym.robot": name,
        "PACKAGE_VERSION": contract.irsim_gym,
        "CONTRACT_PERIOD": f"{contract.period:g}",
        "SCANNER_YAW": f"{float(scan.mount[2]) if scan else 0.0}",
        "NO_RETURN": scan.no_return if scan else "inf",
        "ROBOT_RADIUS": f"{contract.robot.radius:.4g}",
        "SCAN_AGE": f"{contract.stop.scan_age:.4g}",
    }
    texts = {f"{OWN}/__init__.py": '"""Drives a robot by a policy."""\n'}
    if node == "ros2":
        texts[f"resource/{OWN}"] = ""
    for source, place in SHARED.items():
        texts[place] = (HERE / source).read_text(encoding="utf-8")
    for source, place in FILES[node].items():
        texts[place] = (HERE / node / source).read_text(encoding="utf-8")
    return {place.replace(OWN, name): _replaced(text, words) for place, text in texts.items()}


def _replaced(text: str, words: dict[str, str]) -> str:
    for word, value in words.items():
        text = text.replace(word, value)
    return text
