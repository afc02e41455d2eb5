"""Measures how well ``tracks`` show what moves: against the truth, while the robot drives at random."""

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from rich.table import Table

from irsim_gym.base.arraytypes import Flags, Floats, Ints
from irsim_gym.evaluation.protocol.tables import figure_table
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.simulator.tracks.tracker import are_movers
from irsim_gym.simulator.world.own_scan import find_hits
from irsim_gym.tasks import Episodes

TASK = {"name": "blank", "observations": ["tracks"], "max_steps": 300}
LEAST_BEAMS, SEEN_FOR, HELD_FOR = 2, 0.5, 1.0
"""How many beams see a body, how long it has to be seen before it counts, and how long a random action is held [s]."""
NEAR, SLOWEST, ON_EDGE = 0.5, 0.1, 0.02
"""How far the track of a body may be from it [m], which bodies move [m/s], and where hits belong to a body [m]."""
GOOD, DISTANCES = 0.1, (0.0, 2.0, 4.0, 6.0, np.inf)
"""How far a velocity may be from the true one [m/s], and the distances for which shares are told [m]."""


@dataclass
class Tracking:
    """What was seen and followed, one entry for each moving body and step in which it had been seen for long enough.

    Attributes:
        minutes: Simulated time [min].
        away: Distances of the bodies [m], in parts of shape ``(n,)``.
        off: How far their tracks are from them [m], infinite without one, likewise.
        wrong: How far the velocities are from theirs [m/s], likewise.
        false: Tracks where no body that can move was.
        switches: How often another track went on with a body.
    """

    minutes: float
    away: list[Floats] = field(default_factory=list)
    off: list[Floats] = field(default_factory=list)
    wrong: list[Floats] = field(default_factory=list)
    false: int = 0
    switches: int = 0


def measure_tracks(request: ScenarioRequest, levels: int, split: str, seed: int = 0) -> Tracking:
    """Drive the first learner of a scenario at random through levels, and compare its tracks with what moves.

    A body is seen while at least two beams end on the circle around it, which is exact for discs. It has to have been
    seen for 0.5 s, and to be faster than 0.1 m/s.

    Args:
        request: The scenario; its task is not used.
        levels: Number of levels, 300 steps each.
        split: Split of the levels.
        seed: Seed of the actions.
    """
    episodes, rng = replace(request, task=TASK, team=False).episodes(levels), np.random.default_rng(seed)
    episodes.begin(np.arange(levels), np.arange(levels), split)
    model, own = episodes.simulation.model, int(episodes.simulation.agents[0])
    dt, moves = float(model.step_time[0]), ~model.stands & ~model.unobstructed
    moves[own] = False
    movers, n_tracks = np.flatnonzero(moves), episodes.terms["observations"][0].arrays.tracker.tracks.shape[2]
    age, last = np.zeros((levels, len(movers)), np.int64), np.full((levels, len(movers)), -1)
    found, ghosts = Tracking(levels * episodes.task.max_steps * dt / 60.0), np.zeros((levels, n_tracks), np.bool_)
    for step in range(episodes.task.max_steps):
        if step % max(round(HELD_FOR / dt), 1) == 0:
            action = rng.uniform(-1.0, 1.0, (levels, 1, int(episodes.action_sizes[0])))
        episodes.step(action)
        age = np.where(_is_seen(episodes, own, movers), age + 1, 0)
        ghosts = _compare(episodes, own, movers, age * dt > SEEN_FOR, last, ghosts, found)
    return found


def _is_seen(episodes: Episodes, own: int, movers: Ints) -> Flags:
    """Return whether at least two beams end on the edge of each body, ``(n_worlds, n_movers)``."""
    state, model = episodes.simulation.state, episodes.simulation.model
    scan, seen = episodes.terms["observations"][0].arrays.tracker.scan, model.present[:, movers]
    points = np.zeros((2, scan.ranges.shape[2]))
    for w in range(episodes.n_worlds):
        count, (x, y, heading) = find_hits(scan, w, 0, np.inf, points), state.pose[w, own]
        ends = (x + 1j * y) + np.exp(1j * heading) * (points[0, :count] + 1j * points[1, :count])
        away = np.abs(state.pose[w, movers, None, 0] + 1j * state.pose[w, movers, None, 1] - ends)
        hits = np.abs(away - model.reach[w % len(model.reach), movers, None]) < ON_EDGE
        seen[w] &= hits.sum(axis=1) >= LEAST_BEAMS
    return seen


def _compare(
    episodes: Episodes, own: int, movers: Ints, counts: Flags, last: Ints, ghosts: Flags, found: Tracking
) -> Flags:
    """Compare the tracks of a step with the bodies, and return which tracks have been false, ``(n_worlds, n_tracks)``.

    Args:
        counts: Which bodies have been seen for long enough, ``(n_worlds, n_movers)``.
        last: The track that each body had last, -1 for none, likewise; written.
        ghosts: Which tracks had been false before.
        found: What is added to.
    """
    state, tracks = episodes.simulation.state, episodes.terms["observations"][0].arrays.tracker.tracks[:, 0]
    movers_seen, place = are_movers(tracks), state.pose[:, movers]
    speed = np.where(state.stopped[:, movers, None], 0.0, state.twist[:, movers, :2])
    gap = np.hypot(tracks["x"][:, :, None] - place[:, None, :, 0], tracks["y"][:, :, None] - place[:, None, :, 1])
    gap[~movers_seen] = np.inf
    best, rows = gap.argmin(axis=1), np.arange(len(tracks))[:, None]
    off = gap.min(axis=1)
    wrong = np.hypot(tracks["vx"][rows, best] - speed[..., 0], tracks["vy"][rows, best] - speed[..., 1])
    counts = counts & (np.hypot(speed[..., 0], speed[..., 1]) > SLOWEST)
    has_one = off < NEAR
    found.away.append(np.hypot(*(place - state.pose[:, [own]]).T[:2]).T[counts])
    found.off.append(np.where(has_one, off, np.inf)[counts])
    found.wrong.append(np.where(has_one, wrong, np.inf)[counts])
    found.switches += int((counts & has_one & (last >= 0) & (last != best)).sum())
    last[counts & has_one] = best[counts & has_one]
    is_false = movers_seen & (tracks["lost"] == 0.0) & (gap.min(axis=2, initial=np.inf) > NEAR)
    found.false += int((is_false & ~ghosts).sum())
    false: Flags = movers_seen & (ghosts | is_false)
    return false


def tracking_table(found: Tracking) -> Table:
    """Return the shares and errors by distance."""
    away, off, wrong = (np.concatenate(parts) for parts in (found.away, found.off, found.wrong))
    rows = []
    for low, high in (*pairwise(DISTANCES), (0.0, np.inf)):
        part = (low <= away) & (away < high)
        if part.any():
            shares = [f"{100.0 * each[part].mean():.1f}" for each in (off < NEAR, wrong <= GOOD)]
            errors = [f"{np.quantile(each[part & (off < NEAR)], 0.9):.3f}" for each in (off, wrong)]
            rows.append([f"{low:g} to {high:g} m", str(part.sum()), *shares, *errors])
    heads = "distance", "bodies x steps", "tracked %", f"within {GOOD:g} m/s %", "90 % within [m]", "[m/s]"
    return figure_table("moving bodies that have been seen for 0.5 s", heads, rows)
