"""The command ``irsim-gym bag fit``: what a bag says of a robot, as disturbances for a simulation."""

from typing import NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats
from irsim_gym.robot.bags.lag import Estimate, fit_lag
from irsim_gym.robot.bags.read import Bag, lost_beams, seconds, twist

UNTOLD = "cannot be told from this bag"
STILL = 0.05
"""Slower than this, a robot stands [m/s, rad/s]."""
SAME = 0.1
"""Ranges that differ by less are of the same surface [m]."""
LEAST_SCANS = 10
WIDEST = 0.1
"""Length of an interval [s] from which on nothing is told."""


class BagFit(NamedTuple):
    """What a bag says of a robot; a text says why something is not told.

    Attributes:
        periods: Time from one message to the next [s] by role, with the 5 and 95 % quantiles.
        wait: Time from a scan to the command after it [s].
        latency: Time from a command until the wheels begin to follow [s].
        tau: Time constant of the drive [s].
        noise: Standard deviation of ranges [m].
        lost: Share of lost beams.
        reads: What lost beams read: ``none`` or ``zero``.
    """

    periods: dict[str, Estimate]
    wait: float
    latency: Estimate | str
    tau: Estimate | str
    noise: Estimate | str
    lost: Estimate | str
    reads: str


def fit_bag(bag: Bag, no_return: str = "") -> BagFit:
    """Return what a bag says of a robot.

    Args:
        bag: The bag.
        no_return: ``"zero"`` for a scanner that reports 0 where nothing is in range.
    """
    times = {role: _times(bag, role) for role in ("command", "scan", "odometry")}
    periods = {role: _period(found) for role, found in times.items() if len(found) > 1}
    velocities, commands = (
        np.array([twist(event.message) for event in bag.of(role)]).reshape(-1, 3) for role in ("odometry", "command")
    )
    response = fit_lag(times["command"], commands, times["odometry"], velocities)
    latency, tau = (response, response) if isinstance(response, str) else response
    noise, lost, reads = _fit_scans(bag, times["odometry"], velocities, no_return)
    wait = _wait(times["command"], times["scan"])
    return BagFit(periods, wait, latency, tau, noise, lost, reads)


def _times(bag: Bag, role: str) -> Floats:
    """Return when messages were measured or, without a stamp, recorded [s]."""
    stamps = [getattr(event.message, "header", None) for event in bag.of(role)]
    pairs = zip(stamps, bag.of(role), strict=True)
    return np.array([event.time if stamp is None else seconds(stamp.stamp) for stamp, event in pairs])


def _period(times: Floats) -> Estimate:
    low, middle, high = np.quantile(np.diff(times), (0.05, 0.5, 0.95))
    return Estimate(float(middle), float(low), float(high))


def _wait(commands: Floats, scans: Floats) -> float:
    """Return how old the newest scan is when a command is given [s]; 0 without scans or commands."""
    after = commands[commands >= scans[0]] if len(scans) else commands[:0]
    return float(np.median(after - scans[np.searchsorted(scans, after, side="right") - 1])) if len(after) else 0.0


def _fit_scans(
    bag: Bag, moments: Floats, velocities: Floats, no_return: str
) -> tuple[Estimate | str, Estimate | str, str]:
    """Return noise and share of lost beams, or why they are not told, and what lost beams read."""
    messages = [event.message for event in bag.of("scan")]
    if len(messages) < LEAST_SCANS or len({len(message.ranges) for message in messages}) > 1:
        why = "it has too few scans" if len(messages) < LEAST_SCANS else "its scans differ in their number of beams"
        return why, why, "none"
    ranges = np.array([message.ranges for message in messages], float)
    broken = np.array([lost_beams(message, no_return) for message in messages])
    seen = np.isfinite(ranges) & ~broken & (ranges < messages[0].range_max) & (ranges > 0.0)
    if not len(moments):
        return "it has no odometry", *_fit_lost(ranges, seen, broken)
    times = _times(bag, "scan")
    nearest = np.abs(velocities).max(axis=1)[np.clip(np.searchsorted(moments, times), 0, len(moments) - 1)]
    return _fit_noise(ranges, seen, nearest < STILL), *_fit_lost(ranges, seen, broken)


def _fit_noise(ranges: Floats, seen: Flags, stands: Flags) -> Estimate | str:
    """Return the noise, from how beams change while the robot stands."""
    pairs = np.flatnonzero(stands[1:] & stands[:-1])
    known = np.where(seen, ranges, np.nan)
    changes = [one[np.isfinite(one)] for one in np.abs(known[pairs + 1] - known[pairs])]
    # Two ranges differ by sqrt(2) times the noise; the median, since bodies may move through some beams.
    found = np.array([1.4826 * np.median(one) / np.sqrt(2.0) for one in changes if len(one) >= LEAST_SCANS])
    if len(found) < LEAST_SCANS:
        return f"the robot stands still in fewer than {LEAST_SCANS} pairs of scans that hit something"
    middle, off = float(np.mean(found)), 1.96 * float(np.std(found)) / np.sqrt(len(found))
    return Estimate(middle, max(middle - off, 0.0), middle + off)


def _fit_lost(ranges: Floats, seen: Flags, broken: Flags) -> tuple[Estimate | str, str]:
    """Return the share of beams that are lost between two scans that see the same surface, and what they read."""
    known = np.where(seen, ranges, np.nan)
    # A beam beside it sees something, too: a gap between two bodies is no loss.
    beside = np.roll(seen, 1, axis=1) | np.roll(seen, -1, axis=1)
    same = (np.abs(known[2:] - known[:-2]) < SAME) & beside[1:-1]
    lost, counts = (same & ~seen[1:-1]).sum(axis=1), same.sum(axis=1)
    if counts.sum() < 100:
        return "no beams see the same surface twice", "none"
    share = float(lost.sum() / counts.sum())
    off = 1.96 * float(np.std(lost - share * counts)) * np.sqrt(len(counts)) / counts.sum()
    zeros = broken[1:-1] & same & (ranges[1:-1] >= 0.0)
    return Estimate(share, max(share - off, 0.0), share + off), "zero" if 2 * zeros.sum() > lost.sum() else "none"


def section(found: BagFit, bag: Bag) -> list[str]:
    """Return a section ``disturbances:`` of a scenario file, line by line; what is not told is a comment."""
    counts = ", ".join(f"{len(bag.of(role))} {role}" for role in found.periods)
    lines = [
        f"# From {bag.file.name}: {bag.events[-1].time - bag.events[0].time:.1f} s; messages: {counts}.",
        "# Scenarios do not read this section yet. Intervals of 95 % are in brackets.",
    ]
    for role, period in found.periods.items():
        lines.append(f"# {role}: each {_told(period)} s (5 and 95 % of the times between two)")
    lines.append("disturbances:")
    if isinstance(found.latency, str) or found.latency.width > WIDEST:
        lines.append(f"  # latency: {_untold(found.latency)}")
    else:
        low, high = found.latency.low + found.wait, found.latency.high + found.wait
        total = f"{found.wait + found.latency.value:.3f}}}  # [{low:.3f}, {high:.3f}]"
        lines.append(f"  - {{name: latency, time: {total}, of which {found.wait:.3f} before the command")
    if isinstance(found.tau, str) or found.tau.width > max(WIDEST, 0.5 * found.tau.value):
        lines.append(f"  # drive_lag: {_untold(found.tau)}")
    else:
        lines.append(f"  - {{name: drive_lag, tau: {_told(found.tau, '}  # ')}")
    if isinstance(found.lost, str):
        lines.append(f"  # lost_beams: {_untold(found.lost)}")
    else:
        end = f", reads: {found.reads}}}  # "
        lines.append(f"  - {{name: lost_beams, chance: {_told(found.lost, end)}")
    noise = _untold(found.noise) if isinstance(found.noise, str) else f"{_told(found.noise, ' m ')}, std of the sensor"
    return [*lines, f"  # noise of ranges: {noise}"]


def _told(found: Estimate, between: str = " ") -> str:
    return f"{found.value:.3f}{between}[{found.low:.3f}, {found.high:.3f}]"


def _untold(found: Estimate | str) -> str:
    why = found if isinstance(found, str) else f"all from {found.low:.2f} to {found.high:.2f} s fits"
    return f"{UNTOLD} ({why})"
