"""The command ``irsim-gym bag check``: a bag replayed through an export."""

import re
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.outside_files import json_object, reading
from irsim_gym.robot.bags.read import KIND, Bag, Event, lost_beams, seconds, twist
from irsim_gym.robot.contract import RobotContract
from irsim_gym.robot.drive import Driver

GRAPH = "graph of an export"
REGULAR = 0.2
"""Share by which recorded commands may miss the contract's period, and still be the ticks of the driver."""
COMPONENTS = {"omni": ("x [m/s]", "y [m/s]"), "omni_angular": ("x [m/s]", "y [m/s]", "turn [rad/s]")}
OTHERS = ("ahead [m/s]", "turn [rad/s]")
PLACES = {"omni": [0, 1], "omni_angular": [0, 1, 2]}


class BagCheck(NamedTuple):
    """What a driver makes of a bag, tick by tick.

    Attributes:
        components: Names of the components of a command.
        times: When the driver commands, from the first message on [s], ``(n,)``.
        commands: What it commands, ``(n, n_components)``.
        recorded: The newest recorded command, NaN before the first, ``(n, n_components)``.
        reasons: Why it stands still; empty while it drives.
        ages: Ages of scan and odometry [s], infinite before the first, ``(n, 2)``.
        lost: Time [s] and share of lost beams of each scan, ``(n_scans, 2)``.
    """

    components: tuple[str, ...]
    times: Floats
    commands: Floats
    recorded: Floats
    reasons: Sequence[str]
    ages: Floats
    lost: Floats

    def stops(self) -> list[tuple[float, float, str]]:
        """Return first and last tick [s] of each stop, and its reason as at the first."""
        found = []
        for is_stop, ticks in groupby(range(len(self.times)), lambda k: without_numbers(self.reasons[k])):
            first, *others = ticks
            if is_stop:
                found.append((self.times[first], self.times[(others or [first])[-1]], self.reasons[first]))
        return found


def without_numbers(reason: str) -> str:
    """Return what stops of one kind have in common."""
    return re.sub(r"\d[\d.]*", "", reason)


def check_bag(bag: Bag, folder: Path, no_return: str = "") -> BagCheck:
    """Replay a bag through an export.

    The driver ticks where a command was recorded, if these have its period; else by a clock of its own.

    Args:
        bag: The bag.
        folder: The export.
        no_return: ``"zero"`` for a scanner that reports 0 where nothing is in range.

    Raises:
        UnreadableFileError: The folder is no export, or a message lacks what the driver reads.
        IrsimGymError: The bag lacks what the policy needs.
    """
    with reading(folder / "contract.json", "contract of an export"):
        contract = RobotContract.model_validate(json_object(folder / "contract.json"))
    graph = folder / "policy.onnx"
    with reading(graph, GRAPH):
        driver = Driver(folder / "contract.json", no_return)
    for role in ("scan", "odometry") if contract.scan else ("odometry",):
        if not bag.of(role):
            raise IrsimGymError(f"{bag.file} has no {role}, which the policy needs")
    drive, size = contract.robot.drive, len(contract.robot.low)
    components, places = COMPONENTS.get(drive, OTHERS), PLACES.get(drive, [0, 2])
    newest, stamps = np.full(size, np.nan), {"scan": -np.inf, "odometry": -np.inf}
    rows: list[tuple[Any, ...]] = []
    lost: list[tuple[float, float]] = []
    start = bag.events[0].time
    for event in sorted([*bag.events, *_ticks(bag, contract.period)], key=lambda one: one.time):
        with reading(*((graph, GRAPH) if event.role == "tick" else (bag.file, KIND))):
            if event.role == "tick":
                *command, reason = driver.tick(event.time)
                ages = [event.time - stamp for stamp in stamps.values()]
                rows.append((event.time - start, command, newest, reason, ages))
            elif event.role == "command":
                newest = np.array(twist(event.message))[places]
            else:
                getattr(driver, event.role)(event.message)
            if event.role in stamps:
                stamps[event.role] = seconds(event.message.header.stamp)
            if event.role == "scan":
                lost.append((event.time - start, float(lost_beams(event.message, driver.no_return).mean())))
    times, commands, recorded, reasons, ages = zip(*rows, strict=True)
    arrays = (np.array(one, float).reshape(len(rows), -1) for one in (commands, recorded, ages))
    commands, recorded, ages = arrays
    return BagCheck(components, np.array(times), commands, recorded, reasons, ages, np.array(lost).reshape(-1, 2))


def _ticks(bag: Bag, period: float) -> list[Event]:
    """Return when the driver ticks; sorted by time, ticks come behind messages of the same time."""
    times = np.array([event.time for event in bag.of("command")])
    if len(times) < 2 or abs(np.median(np.diff(times)) - period) > REGULAR * period:
        first, last = bag.events[0].time, bag.events[-1].time
        times = first + period * np.arange(1, int((last - first) / period) + 2)
    return [Event(float(time), "tick", None) for time in times]


def report(found: BagCheck, bag: Bag) -> list[str]:
    """Return what a replay shows as lines of text."""
    apart = np.abs(found.commands - found.recorded).max(axis=1)
    lines = [f"{bag.file}: {found.times[-1]:.1f} s, {len(found.times)} commands of the driver"]
    if np.isfinite(apart).any():
        most, middle = int(np.nanargmax(apart)), float(np.nanmedian(apart))
        lines.append(f"from the recorded ones: {middle:.1e} (median), {apart[most]:.1e} at {found.times[most]:.2f} s")
    for name, ages in zip(("scans", "odometry"), found.ages.T, strict=True):
        if np.isfinite(ages).any():
            known = ages[np.isfinite(ages)]
            lines.append(f"age of {name}: {np.median(known):.3f} s (median), {known.max():.3f} s at most")
    if len(found.lost):
        lines.append(f"lost beams: {found.lost[:, 1].mean():.1%} on average, {found.lost[:, 1].max():.1%} at most")
    stops = found.stops()
    return lines + [f"stands still from {first:.2f} to {last:.2f} s: {reason}" for first, last, reason in stops]
