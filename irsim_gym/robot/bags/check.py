"""The command ``irsim-gym bag check``: a bag replayed through an export."""

import re
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.outside_files import reading
from irsim_gym.robot.bags.read import KIND, Bag, Event, twist
from irsim_gym.robot.contract import read_export
from irsim_gym.robot.drive import Driver
from irsim_gym.robot.parts.shield import AXES
from irsim_gym.robot.scans import lost_beams, seconds

REGULAR = 0.2
"""Share by which recorded commands may miss the contract's period, and still be the ticks of the driver."""


class BagCheck(NamedTuple):
    """What a driver makes of a bag, tick by tick.

    Attributes:
        times: When the driver commands, from the first message on [s], ``(n,)``.
        commands: What it commands: ahead, left [m/s], turn [rad/s], ``(n, 3)``.
        recorded: The newest recorded command, NaN before the first, ``(n, 3)``.
        ages: Ages of scan and odometry [s], infinite before the first, ``(n, 2)``.
        reasons: Why it stands still; empty while it drives.
        lost: Time [s] and share of lost beams of each scan, ``(n_scans, 2)``.
    """

    times: Floats
    commands: Floats
    recorded: Floats
    ages: Floats
    reasons: Sequence[str]
    lost: Floats

    def stops(self) -> list[tuple[float, float, str, str]]:
        """Return first and last tick [s] of each stop, its reason at the first, and the reason without numbers."""
        found = []
        for words, ticks in groupby(range(len(self.times)), lambda k: re.sub(r"\d[\d.]*", "", self.reasons[k])):
            every = list(ticks)
            if words and not self.commands[every].any():
                found.append((self.times[every[0]], self.times[every[-1]], self.reasons[every[0]], words))
        return found


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
    contract, _ = read_export(folder)
    driver = Driver(folder / "contract.json", no_return)
    if contract.bodies:
        raise IrsimGymError(f"{folder} needs other bodies, which bags do not hold")
    for role in ("scan", "odometry") if contract.scan else ("odometry",):
        if not bag.of(role):
            raise IrsimGymError(f"{bag.file} has no {role}, which the policy needs: name its topic with --topic")
    start, stamps, newest = bag.events[0].time, {"scan": -np.inf, "odometry": -np.inf}, np.full(3, np.nan)
    rows, reasons = list[Floats](), list[str]()
    with reading(bag.file, KIND):
        for event in sorted([*bag.events, *_ticks(bag, contract.period)], key=lambda one: one.time):
            if event.role == "tick":
                *command, reason = driver.tick(event.time)
                whole = np.zeros(3)
                whole[AXES.get(contract.robot.drive, AXES["diff"])] = command
                waited = [event.time - stamp for stamp in stamps.values()]
                rows.append(np.array([event.time - start, *whole, *newest, *waited]))
                reasons.append(reason)
            elif event.role == "command":
                newest = np.array(twist(event.message))
            else:
                getattr(driver, event.role)(event.message)
            if event.role in stamps:
                stamps[event.role] = seconds(event.message.header.stamp)
        lost = [(one.time - start, lost_beams(one.message, driver.no_return).mean()) for one in bag.of("scan")]
    times, commands, recorded, ages = np.split(np.array(rows), [1, 4, 7], axis=1)
    return BagCheck(times[:, 0], commands, recorded, ages, reasons, np.array(lost).reshape(-1, 2))


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
        known = ages[np.isfinite(ages)]
        if len(known):
            lines.append(f"age of {name}: {np.median(known):.3f} s (median), {known.max():.3f} s at most")
    if len(found.lost):
        lines.append(f"lost beams: {found.lost[:, 1].mean():.1%} on average, {found.lost[:, 1].max():.1%} at most")
    return lines + [f"stands still from {one[0]:.2f} to {one[1]:.2f} s: {one[2]}" for one in found.stops()]
