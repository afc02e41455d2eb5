"""A Ray session for one command: a local Ray that only listens on the loopback interface, or a given cluster."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from irsim_gym.base.errors import IrsimGymError

QUIET = {
    "RAY_USAGE_STATS_ENABLED": "0",  # Ray sends no usage statistics
    "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0",  # workers without a GPU do not change CUDA_VISIBLE_DEVICES
    "RAY_BACKEND_LOG_LEVEL": "fatal",
}
SILENT: dict[str, Any] = {"logging_level": logging.ERROR, "log_to_driver": False}
LOOPBACK = "RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"
"""If this is 0 when Ray is imported, its servers listen on 127.0.0.1 only, as they do on Windows and macOS."""


@contextmanager
def ray_session(address: str | None, processes: int) -> Iterator[None]:
    """Start Ray or connect to a cluster, and shut it down at the end. A Ray that is already initialized is used as is.

    Args:
        address: ``"auto"``, ``"ray://host:port"`` or ``"host:port"``; None starts Ray on this machine.
        processes: Largest number of simultaneous processes of a local Ray.

    Raises:
        IrsimGymError: If there is no cluster at the address.
    """
    prepare(address)
    import ray

    for name in ("ray.rllib", "ray.tune"):
        logging.getLogger(name).setLevel(logging.ERROR)  # they warn of their own defaults
    if ray.is_initialized():
        yield
        return
    try:
        if address is None:
            # "local" does not connect to a Ray that already runs on this machine.
            ray.init("local", num_cpus=processes, include_dashboard=False, **SILENT)
        else:
            ray.init(address, **SILENT)
    except ConnectionError as error:
        raise IrsimGymError(f"no Ray cluster at {address}: {error}") from error
    try:
        yield
    finally:
        ray.shutdown()


def prepare(address: str | None) -> None:
    """Set the environment variables that Ray reads when it is imported.

    Raises:
        IrsimGymError: If Ray was already imported such that it would accept connections from other machines.
    """
    for name, value in QUIET.items():
        os.environ.setdefault(name, value)
    if address is not None:
        return
    late = "ray" in sys.modules and os.environ.get(LOOPBACK) != "0"
    if late and not sys.modules["ray"].is_initialized():
        raise IrsimGymError(
            f"Ray was imported before {LOOPBACK}=0 was set and would listen to other machines: set it first, or call "
            "ray.init yourself"
        )
    os.environ[LOOPBACK] = "0"
