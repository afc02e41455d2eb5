"""How late and how slowly a robot follows its commands: a delay and a first-order lag, from velocities in a bag."""

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.evaluation.measures.statistics import Estimate

LAGS, TAUS = np.arange(0.0, 1.01, 0.02), np.array([1e-3, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.45, 0.7, 1.0, 1.5])
"""Delays and time constants that are tried first [s]."""
FINE, REFINEMENTS, MARGIN = 33, 3, 2
"""Number of delays and of time constants that are tried next; how often; by how many steps beyond those that fit."""
FLOOR, LEAST_CHANGE = 1e-3, 0.05
"""Least noise of a velocity that is believed, and least deviation of a command that tells anything [m/s, rad/s]."""
FEWEST, MOST = 50, 5000
"""Numbers of velocities that are needed, and that are used."""
LONGEST_GAP = 0.5
"""After this time without a command, robots may stop by themselves [s]."""
LIKELY = 1e-3
"""Likelihood, relative to the best, of what is tried again with finer steps."""


def fit_lag(
    times: Floats, commands: Floats, moments: Floats, velocities: Floats
) -> tuple[Estimate, Estimate] | tuple[str, str]:
    """Return the delay from a command to the wheels and the time constant of the drive [s]; texts say why not.

    Args:
        times: Times of the commands [s], ``(n,)``.
        commands: The commands, ``(n, n_components)``.
        moments: Times of the velocities [s], ``(m,)``.
        velocities: The measured velocities, ``(m, n_components)``.
    """
    newest = np.searchsorted(times, moments, side="right") - 1
    rows = np.flatnonzero((newest >= 0) & (moments - np.append(times, -np.inf)[newest] < LONGEST_GAP))
    if len(rows) < FEWEST:
        return ("it has too few commands and velocities",) * 2
    moving = np.flatnonzero(commands.std(axis=0) > LEAST_CHANGE)
    if not len(moving):
        return ("its commands hardly change",) * 2
    rows, (lags, taus) = rows[:: -(-len(rows) // MOST)], (LAGS, TAUS)
    measured = times, commands[:, moving], moments[rows], velocities[np.ix_(rows, moving)]
    for _ in range(REFINEMENTS):
        weights = _weights(*measured, lags, taus)
        likely = np.nonzero(weights > LIKELY * weights.max())
        lags, taus = (
            np.linspace(axis[max(k.min() - MARGIN, 0)], axis[min(k.max() + MARGIN, len(axis) - 1)], FINE)
            for axis, k in zip((lags, taus), likely, strict=True)
        )
    weights = _weights(*measured, lags, taus)
    return _estimate(lags, weights.sum(axis=1)), _estimate(taus, weights.sum(axis=0))


def _weights(
    times: Floats, commands: Floats, moments: Floats, velocities: Floats, lags: Floats, taus: Floats
) -> Floats:
    """Return how likely each delay and time constant is, relative to the best, ``(n_lags, n_taus)``."""
    acting = moments - lags[:, None]
    k = np.maximum(np.searchsorted(times, acting) - 1, 0)  # the newest command that acts before
    since = np.maximum(acting - times[k], 0.0)[:, :, None]
    squares, rows = np.zeros((len(lags), len(taus), commands.shape[1])), []
    for column, tau in enumerate(taus):
        states = [velocities[0]]  # where each command begins to act
        for command, fading in zip(commands, np.exp(-np.diff(times) / tau), strict=False):
            states.append(command + (states[-1] - command) * fading)
        errors = commands[k] + (np.array(states) - commands)[k] * np.exp(-since / tau) - velocities
        squares[:, column] = (errors**2).mean(axis=1)
        rows.append(errors[squares[:, column].sum(axis=1).argmin()])
    best = rows[squares.sum(axis=2).min(axis=0).argmin()]
    # Errors that follow each other tell less: as many are counted as would be independent.
    alike = np.clip((best[1:] * best[:-1]).sum(axis=0) / ((best**2).sum(axis=0) + FLOOR**2), 0.0, None)
    surprise = (len(best) * (1.0 - alike) / (1.0 + alike) * np.log(squares + FLOOR**2)).sum(axis=2)
    weights: Floats = np.exp(-0.5 * (surprise - surprise.min()))
    return weights


def _estimate(values: Floats, weights: Floats) -> Estimate:
    """Return the mean of values by their weights, and the interval that has 95 % of them."""
    half, share = 0.5 * (values[1] - values[0]), np.cumsum(weights) / weights.sum()
    low, high = values[np.searchsorted(share, (0.025, 0.975))].tolist()
    return Estimate(float(np.average(values, weights=weights)), max(low - half, 0.0), high + half)
