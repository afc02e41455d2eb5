"""A ROS package around an exported policy: its node, driver, launch file and manifests."""

import re
from pathlib import Path

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.robot.contract import RobotContract

HERE = Path(__file__).parent
KINDS = ("ros1", "ros2")
"""Folders with the files of a package in their places; code that is no module of ours ends with ``.py.txt``."""
OWN = "policy_driver"
"""Stands for the name of the package in the files and their places."""


def check_node(node: str | None) -> None:
    """Raise an IrsimGymError if there is no package for a node."""
    if node is not None and node not in KINDS:
        raise IrsimGymError(f"--node: there is no '{node}': choose {' or '.join(KINDS)}")


def package_name(policy: str) -> str:
    """Return the name of a policy's ROS package: small letters, digits and single underscores, a letter first."""
    words = re.sub(r"[^a-z0-9]+", "_", policy.lower()).strip("_")
    return f"{words}_driver" if words[:1].isalpha() else f"policy_{words}_driver"


def package_files(contract: RobotContract, node: str) -> dict[str, str]:
    """Return the texts of a ROS package by their places in it; it installs the files of the export.

    Args:
        contract: The contract of the export.
        node: ``ros1`` or ``ros2``.
    """
    name, scan, root = package_name(contract.policy), contract.scan, HERE / node
    words = {
        ".py.txt": ".py",
        OWN: name,
        "irsim_gym.robot.nodes": name,
        "PACKAGE_VERSION": contract.irsim_gym,
        "CONTRACT_PERIOD": f"{contract.period:g}",
        **{
            f"SCANNER_{part}": f"{float(scan.mount[k]) if scan else 0.0}"
            for k, part in enumerate(("AHEAD", "LEFT", "YAW"))
        },
        "NO_RETURN": scan.no_return if scan else "inf",
        "ROBOT_RADIUS": f"{contract.robot.radius:.4g}",
        "SCAN_AGE": f"{contract.stop.scan_age:.4g}",
    }
    files = {file.relative_to(root).as_posix(): file for file in sorted(root.rglob("*")) if file.is_file()}
    places = {place: file for place, file in files.items() if place != "__init__.py" and "__pycache__" not in place}
    places[f"{OWN}/driving.py"] = HERE / "driving.py"
    return {_replaced(place, words): _replaced(one.read_text(encoding="utf-8"), words) for place, one in places.items()}


def _replaced(text: str, words: dict[str, str]) -> str:
    for word, value in words.items():
        text = text.replace(word, value)
    return text
