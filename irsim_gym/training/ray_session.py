"""A Ray that belongs to one command: local, on the loopback alone, or a cluster whose address was given."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from irsim_gym.errors import IrsimGymError

QUIET = {
    "RAY_USAGE_STATS_ENABLED": "0",  # Ray sends nothing to its makers
    "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0",  # workers without a card leave CUDA_VISIBLE_DEVICES alone
    "RAY_AIR_NEW_OUTPUT": "0",  # Tune shows no table of its own
    "RAY_BACKEND_LOG_LEVEL": "fatal",
}
SILENT: dict[str, Any] = {"logging_level": logging.ERROR, "log_to_driver": False}
LOOPBACK = "RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"
"""Where this is 0 before Ray is imported, its servers listen on 127.0.0.1, as they do on Windows and macOS."""


@contextmanager
def ray_session(address: str | None, processes: int) -> Iterator[None]:
    """Start Ray, or connect to a cluster, and leave it again; one that runs in this process already is used as it is.

    Args:
        address: ``"auto"``, ``"ray://host:port"`` or ``"host:port"``; None starts Ray on this machine.
        processes: How many processes a local Ray may run at a time.

    Raises:
        IrsimGymError: There is no cluster at the address.
    """
    prepare(address)
    import ray

    for name in ("ray.rllib", "ray.tune"):
        logging.getLogger(name).setLevel(logging.ERROR)  # they warn of what they do by default
    if ray.is_initialized():
        yield
        return
    try:
        if address is None:
            ray.init("local", num_cpus=processes, include_dashboard=False, **SILENT)  # not to one that happens to run
        else:
            ray.init(address, **SILENT)
    except ConnectionError as error:
        raise IrsimGymError(f"no Ray cluster at {address}: {error}") from error
    try:
        yield
    finally:
        ray.shutdown()


def prepare(address: str | None) -> None:
    """Set what Ray reads from the environment as it is imported.

    Raises:
        IrsimGymError: Ray is imported already, in a way in which it would listen to other machines.
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
