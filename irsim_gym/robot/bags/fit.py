"""The command ``irsim-gym bag fit``: what a bag says of a robot, as disturbances for a simulation."""

from typing import NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats
from irsim_gym.evaluation.measures.statistics import Estimate
from irsim_gym.robot.bags.lag import fit_lag
from irsim_gym.robot.bags.read import Bag, twist
from irsim_gym.robot.scans import lost_beams, seconds

UNTOLD = "cannot be told from this bag"
STILL = 0.05
"""Slower than this, a robot stands [m/s, rad/s]."""
SAME = 0.1
"""Ranges that differ by less are of the same surface [m]."""
LEAST_SCANS, LEAST_BEAMS = 10, 100
WIDEST = 0.1
"""Length of an interval [s] from which on nothing is told."""


class BagFit(NamedTuple):
    """What a bag says of a robot; a text says why something is not told.

    Attributes:
        periods: Time from one message to the next [s] by role, with the 5 and 95 % quantiles.
        wait: Time from a scan to the command after it [s].
        latency: Time from a scan until the wheels begin to follow [s].
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
    gaps = {role: np.diff(moments) for role, moments in times.items() if len(moments) > 1}
    periods = {role: Estimate(*np.quantile(gap, (0.5, 0.05, 0.95)).tolist()) for role, gap in gaps.items()}
    commands, velocities = (
        np.array([twist(event.message) for event in bag.of(role)]).reshape(-1, 3) for role in ("command", "odometry")
    )
    wait = _wait(times["command"], times["scan"])
    delay, tau = fit_lag(times["command"], commands, times["odometry"], velocities)
    latency = delay if isinstance(delay, str) else Estimate(wait + delay.value, wait + delay.low, wait + delay.high)
    messages = [event.message for event in bag.of("scan")]
    if len(messages) < LEAST_SCANS or len({len(message.ranges) for message in messages}) > 1 or not len(velocities):
        why = "it has too few scans of the same number of beams, or no odometry"
        return BagFit(periods, wait, latency, tau, why, why, "none")
    ranges = np.array([message.ranges for message in messages])
    broken = np.array([lost_beams(message, no_return) for message in messages])
    seen = np.isfinite(ranges) & ~broken & (ranges < messages[0].range_max) & (ranges > 0.0)
    nearest = np.clip(np.searchsorted(times["odometry"], times["scan"]), 0, len(velocities) - 1)
    stands = np.abs(velocities[nearest]).max(axis=1) < STILL
    known = np.where(seen, ranges, np.nan)
    return BagFit(periods, wait, latency, tau, _noise(known, stands), *_lost(known, broken & np.isfinite(ranges)))


def _times(bag: Bag, role: str) -> Floats:
    """Return when messages were measured or, without a stamp, recorded [s]."""
    messages = [(event.message, event.time) for event in bag.of(role)]
    return np.array([seconds(one.header.stamp) if hasattr(one, "header") else time for one, time in messages])


def _wait(commands: Floats, scans: Floats) -> float:
    """Return how old the newest scan is when a command is given [s]; 0 without scans or commands."""
    after = commands[commands >= scans[0]] if len(scans) else commands[:0]
    return float(np.median(after - scans[np.searchsorted(scans, after, side="right") - 1])) if len(after) else 0.0


def _noise(known: Floats, stands: Flags) -> Estimate | str:
    """Return the noise, from how beams change while the robot stands; ranges that are not known are NaN."""
    pairs = np.flatnonzero(stands[1:] & stands[:-1])
    changes = [one[np.isfinite(one)] for one in np.abs(known[pairs + 1] - known[pairs])]
    # Two ranges differ by sqrt(2) times the noise; the median, since bodies may move through some beams.
    deviations = np.array([1.4826 * np.median(one) / np.sqrt(2.0) for one in changes if len(one) >= LEAST_SCANS])
    if len(deviations) < LEAST_SCANS:
        return "the robot hardly stands still"
    middle, off = float(deviations.mean()), 1.96 * float(deviations.std()) / np.sqrt(len(deviations))
    return Estimate(middle, max(middle - off, 0.0), middle + off)


def _lost(known: Floats, zeros: Flags) -> tuple[Estimate | str, str]:
    """Return the share of beams that are lost between two scans that see the same surface, and what they read."""
    seen = np.isfinite(known)
    # A beam beside it sees something, too: a gap between two bodies is no loss.
    beside = np.roll(seen, 1, axis=1) | np.roll(seen, -1, axis=1)
    same = (np.abs(known[2:] - known[:-2]) < SAME) & beside[1:-1]
    lost, counts = (same & ~seen[1:-1]).sum(axis=1), same.sum(axis=1)
    if counts.sum() < LEAST_BEAMS:
        return "no beams see the same surface twice", "none"
    share = float(lost.sum() / counts.sum())
    off = 1.96 * float(np.std(lost - share * counts)) * np.sqrt(len(counts)) / counts.sum()
    reads = "zero" if 2 * (same & zeros[1:-1]).sum() > lost.sum() else "none"
    return Estimate(share, max(share - off, 0.0), share + off), reads


def section(found: BagFit, bag: Bag) -> list[str]:
    """Return a section ``disturbances:`` of a scenario file, line by line; what is not told is a comment."""
    counts = ", ".join(f"{len(bag.of(role))} {role}" for role in found.periods)
    lines = [
        f"# From {bag.file.name}: {bag.events[-1].time - bag.events[0].time:.1f} s; messages: {counts}.",
        "# For an entry in robot of a scenario. Intervals of 95 % are in brackets.",
        *(f"# {role}: each {_told(period)} s (5 and 95 % quantiles)" for role, period in found.periods.items()),
        "disturbances:",
        _line("latency", "time", found.latency, note=f"; {found.wait:.3f} of it before the command"),
        _line("drive_lag", "tau", found.tau),
        _line("lost_beams", "chance", found.lost, more=f", reads: {found.reads}"),
    ]
    noise = f"{UNTOLD} ({found.noise})" if isinstance(found.noise, str) else f"std {_told(found.noise)} m of the sensor"
    return [*lines, f"  # noise of ranges: {noise}"]


def _told(found: Estimate, between: str = " ") -> str:
    return f"{found.value:.3f}{between}[{found.low:.3f}, {found.high:.3f}]"


def _line(name: str, key: str, found: Estimate | str, more: str = "", note: str = "") -> str:
    if isinstance(found, Estimate) and found.high - found.low < max(WIDEST, 0.5 * found.value):
        return f"  - {{name: {name}, {key}: {_told(found, f'{more}}}  # ')}{note}"
    why = found if isinstance(found, str) else f"{key} from {found.low:.2f} to {found.high:.2f} s fits"
    return f"  # {name}: {UNTOLD} ({why})"
