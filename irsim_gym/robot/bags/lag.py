"""How late and how slowly a robot follows its commands: a delay and a first-order lag, from velocities in a bag."""

from typing import NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints

LAGS, TAUS = np.arange(0.0, 1.01, 0.02), np.array([1e-3, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.45, 0.7, 1.0, 1.5])
"""Delays and time constants that are tried first [s]."""
FINE, REFINEMENTS, MARGIN = 33, 3, 2
"""Number of delays and of time constants that are tried next; how often; by how many steps beyond those that fit."""
FLOOR = 1e-3
"""Least noise of a velocity that is believed [m/s, rad/s]."""
LEAST_CHANGE = 0.05
"""Least standard deviation of a command that tells anything [m/s, rad/s]."""
FEWEST, MOST = 50, 5000
"""Numbers of velocities that are needed, and that are used."""
LONGEST_GAP = 0.5
"""After this time without a command, robots may stop by themselves [s]."""
UNLIKELY = 14.0
"""Twice the logarithm of the likelihood by which what is unlikely falls behind the best."""


class Estimate(NamedTuple):
    """A value with its 95 % interval."""

    value: float
    low: float
    high: float

    @property
    def width(self) -> float:
        """Length of the interval."""
        return self.high - self.low


class Response(NamedTuple):
    """A component of commands and of measured velocities, with their times [s]."""

    command_times: Floats
    commands: Floats
    times: Floats
    velocities: Floats

    def errors(self, k: Ints, since: Floats, tau: float) -> Floats:
        """Return how far a robot with a time constant is from the measured one, ``(n_lags, n)``.

        Args:
            k: The command that acts at each time, by delay, ``(n_lags, n)``.
            since: For how long it has acted [s].
            tau: The time constant [s].
        """
        decays, state = np.exp(-np.diff(self.command_times) / tau).tolist(), float(self.velocities[0])
        starts = [state]
        for command, decay in zip(self.commands.tolist(), decays, strict=False):
            state = command + (state - command) * decay
            starts.append(state)
        found: Floats = self.commands[k] + (np.array(starts) - self.commands)[k] * np.exp(-since / tau)
        return found - self.velocities


def fit_lag(times: Floats, commands: Floats, moments: Floats, velocities: Floats) -> tuple[Estimate, Estimate] | str:
    """Return the delay from a command to the wheels and the time constant of the drive [s]; why not, as a text.

    Args:
        times: Times of the commands [s], ``(n,)``.
        commands: The commands, ``(n, n_components)``.
        moments: Times of the velocities [s], ``(m,)``.
        velocities: The measured velocities, ``(m, n_components)``.
    """
    if len(times) < 2 or len(moments) < 2:
        return "it has no commands or no odometry"
    age = moments - times[np.maximum(np.searchsorted(times, moments, side="right") - 1, 0)]
    known = np.flatnonzero((age >= 0.0) & (age < LONGEST_GAP))
    moving = np.flatnonzero(commands.std(axis=0) > LEAST_CHANGE)
    if len(known) < FEWEST or not len(moving):
        return "its commands hardly change" if len(known) >= FEWEST else "it is too short"
    known = known[:: -(-len(known) // MOST)]
    parts = [Response(times, commands[:, c], moments[known], velocities[known, c]) for c in moving]
    lags, taus = LAGS, TAUS
    for _ in range(REFINEMENTS):
        weights = _weights(parts, lags, taus)
        likely = np.nonzero(weights > np.exp(-0.5 * UNLIKELY) * weights.max())
        lag_range, tau_range = (_around(axis, places) for axis, places in zip((lags, taus), likely, strict=True))
        lags, taus = np.linspace(*lag_range, FINE), np.linspace(*tau_range, FINE)
    weights = _weights(parts, lags, taus)
    return _estimate(lags, weights.sum(axis=1)), _estimate(taus, weights.sum(axis=0))


def _around(axis: Floats, places: Floats) -> tuple[float, float]:
    """Return the ends of a finer axis around some places."""
    return float(axis[max(places.min() - MARGIN, 0)]), float(axis[min(places.max() + MARGIN, len(axis) - 1)])


def _weights(parts: list[Response], lags: Floats, taus: Floats) -> Floats:
    """Return how likely each delay and time constant is, relative to the best, ``(n_lags, n_taus)``."""
    surprise = np.zeros((len(lags), len(taus)))
    times = parts[0].times - lags[:, None]
    k = np.maximum(np.searchsorted(parts[0].command_times, times) - 1, 0)
    since = np.maximum(times - parts[0].command_times[k], 0.0)
    for part in parts:
        squares, best = np.zeros_like(surprise), (np.inf, 1.0)
        for column, tau in enumerate(taus):
            errors = part.errors(k, since, float(tau))
            squares[:, column] = (errors**2).mean(axis=1)
            row = errors[squares[:, column].argmin()]
            best = min(best, ((row**2).mean(), max(float(row[1:] @ row[:-1] / (row @ row + FLOOR**2)), 0.0)))
        # Errors that follow each other tell less: as many are counted as would be independent.
        count = errors.shape[1] * (1.0 - best[1]) / (1.0 + best[1])
        surprise += count * np.log(squares + FLOOR**2)
    weights: Floats = np.exp(-0.5 * (surprise - surprise.min()))
    return weights


def _estimate(values: Floats, weights: Floats) -> Estimate:
    """Return the mean of values by their weights, and the interval that has 95 % of them."""
    half = 0.5 * (values[1] - values[0])
    share = np.cumsum(weights) / weights.sum()
    low, high = (float(values[np.searchsorted(share, part)]) for part in (0.025, 0.975))
    mean = float(np.average(values, weights=weights))
    return Estimate(mean, max(low - half, 0.0), high + half)
