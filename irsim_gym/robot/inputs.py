"""What a robot measures: as inputs of a graph, and as an environment knows it."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Flags, Floats, Rays, Records
from irsim_gym.base.families import FOOTPRINTS
from irsim_gym.robot.contract import Scanner, SeenMapForm, Tested
from irsim_gym.scenario import Scenario
from irsim_gym.simulator.tracks.tracker import Tracker, are_movers
from irsim_gym.simulator.world.model import OMNI_WORLD, Model
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.observations.seen_map.way_on_seen_map import WayOnSeenMap
from irsim_gym.tasks.terms import Term
from irsim_gym.tasks.terms.graph import Graph, RobotValues, Value

Measured = dict[str, NDArray[Any]]


def limits_of(episodes: Episodes) -> tuple[Floats, Floats]:
    """Return the least and the greatest command of the first agent, each ``(n_components,)``."""
    model, b, size = episodes.simulation.model, episodes.task.agents[0], int(episodes.action_sizes[0])
    return model.velocity_min[0, b, :size], model.velocity_max[0, b, :size]


def scanner_of(episodes: Episodes, agent: int = 0) -> tuple[Any, Rays, Floats] | None:
    """Return the options of an agent's range sensor, its live ranges and its angles; None without one.

    Ranges [m] are ``(n_worlds, n_beams)``, angles [rad] ``(n_beams,)`` in the frame of the sensor.
    """
    scanner = episodes.simulation.scan(episodes.task.agents[agent])
    if scanner is None:
        return None
    group, member = scanner
    return group.options[member], group.arrays["ranges"][:, member], group.arrays["angles"]


def scanner_form(episodes: Episodes) -> Scanner | None:
    """Return what a contract says of the first agent's range sensor; None without one."""
    scanner = scanner_of(episodes)
    if scanner is None:
        return None
    options, _, angles = scanner
    view, n_beams = float(angles[-1] - angles[0]), len(angles)
    step, widest = view / (n_beams - 1) if n_beams > 1 else 0.0, options.range_max
    fan: dict[str, Any] = {"beams": n_beams, "first": float(angles[0]), "step": step}
    mount = {"mount": options.offset, "mounts": tuple((place, place) for place in options.offset)}
    tested = Tested(beams=(n_beams, n_beams), range_max=(widest, widest), field_of_view=(view, view))
    return Scanner(**fan, range_min=options.range_min, range_max=widest, **mount, no_return="inf", tested=tested)


def seen_map_form(episodes: Episodes) -> SeenMapForm | None:
    """Return what a contract says of the map on which the first agent finds its way; None without one."""
    arrays = (term.arrays for term in episodes.terms["observations"] if isinstance(term.options, WayOnSeenMap))
    ways = next(arrays, None)
    if ways is None:
        return None
    grid, model = ways.seen.grid, episodes.simulation.model
    lies = {"origin": (grid.origin_x, grid.origin_y), "cell": grid.cell, "rows": grid.rows, "columns": grid.columns}
    wide = float(model.reach[0, episodes.task.agents[0]]) + ways.clearance
    return SeenMapForm(**lies, inflation=wide, every=ways.seen.every, frees=ways.seen.doubted.shape[1] > 0)


def measured(episodes: Episodes, agent: int = 0) -> Measured:
    """Return what an agent's robot would measure in each world, by the names of the graph's inputs."""
    state, b = episodes.simulation.state, episodes.task.agents[agent]
    pose, velocity = state.pose[:, b].copy(), state.velocity[:, b, : int(episodes.action_sizes[agent])].copy()
    velocity[state.stopped[:, b]] = 0.0  # what it was commanded is kept there
    if episodes.simulation.model.drive[b] == OMNI_WORLD:
        cosine, sine, (x, y) = np.cos(pose[:, 2]), np.sin(pose[:, 2]), velocity.T.copy()
        velocity = np.stack([cosine * x + sine * y, cosine * y - sine * x], axis=1)
    elapsed = np.full((len(pose), 1), episodes.simulation.model.step_time[0])
    values: Measured = {"pose": pose, "velocity": velocity, "goal": state.goal[:, b].copy(), "elapsed": elapsed}
    scanner = scanner_of(episodes, agent)
    tracker = tracker_of(episodes)
    if tracker is not None:
        values["bodies"] = mover_rows(tracker.tracks[:, agent])
    elif seers(episodes):
        values["bodies"] = tracked(episodes, agent)
    return values if scanner is None else {"ranges": scanner[1].copy(), **values}


def among_discs(scenario: Scenario, episodes: Episodes) -> Scenario:
    """Return a scenario in which a tracker gives the first agent all that it sees of others.

    Others that can move become discs that enclose them; outlines that stay where they start are not seen. It is the
    same scenario if there are no such bodies.
    """
    model, bodies = episodes.simulation.model, list(scenario.bodies)
    for b in np.flatnonzero(~is_disc(model) & ~model.unobstructed):
        if not model.stands[b] and b not in episodes.task.agents:
            bodies[b] = replace(bodies[b], shape=FOOTPRINTS.entry("circle").kind(radius=float(model.reach[:, b].max())))
        elif model.stands[b] and not sees_moving_only(episodes):
            bodies[b] = replace(bodies[b], unobstructed=True)
    return scenario if bodies == list(scenario.bodies) else replace(scenario, bodies=tuple(bodies))


def sees_moving_only(episodes: Episodes) -> bool:
    """Return whether all observations of other bodies leave out those that stay where they start."""
    return all(getattr(term.options, "moving", False) for term in seers(episodes))


def seers(episodes: Episodes) -> list[Term]:
    """Return the observations of other bodies."""
    return [term for term in episodes.terms["observations"] if "bodies" in (term.options.needs or ())]


def tracker_of(episodes: Episodes) -> Tracker | None:
    """Return the tracker that observations of tracks share; None without one."""
    arrays = (getattr(term.arrays, "tracker", None) for term in episodes.terms["observations"])
    return next((tracker for tracker in arrays if tracker is not None), None)


def mover_rows(tracks: Records) -> Floats:
    """Return tracks as rows of ``tracked``; NaN for those that scans have not shown to move."""
    rows = np.stack([tracks[name] for name in ("x", "y", "vx", "vy", "radius")], axis=-1)
    return np.where(are_movers(tracks)[..., None], rows, np.nan)


def tracked(episodes: Episodes, agent: int = 0) -> Floats:
    """Return the other bodies that an agent's observations see as a tracker has them, as discs.

    Returns:
        x, y [m], their velocity [m/s] and their radius [m], ``(n_worlds, n, 5)``; NaN where there is none. The disc of
        another outline encloses it. Outlines that stay where they start, such as walls, are left out.
    """
    model, state, body = episodes.simulation.model, episodes.simulation.state, episodes.task.agents[agent]
    discs, is_free = is_disc(model), ~model.unobstructed & (np.arange(len(model.stands)) != body)
    bodies = np.flatnonzero(is_free & (~model.stands | (discs & (not sees_moving_only(episodes)))))
    places = np.concatenate([state.pose[:, :, :2], np.broadcast_to(model.reach, state.stopped.shape)[:, :, None]], 2)
    places[:, discs] = state.discs[:, model.disc_start[discs]]
    velocity = np.where(state.stopped[:, :, None], 0.0, state.twist[:, :, :2])
    rows = np.concatenate([places[:, :, :2], velocity, places[:, :, 2:]], axis=2)
    return np.where(model.present[:, bodies, None], rows[:, bodies], np.nan)


def is_disc(model: Model) -> Flags:
    """Return which bodies are discs, ``(n_bodies,)``."""
    return np.asarray((model.disc_count == 1).all(axis=0) & (model.segment_count == 0).all(axis=0))


def robot_values(graph: Graph, episodes: Episodes, action: Value, agent: int = 0) -> RobotValues:
    """Return the inputs of a graph; the scan is cleaned as REP 117 says.

    Args:
        action: The latest action in [-1, 1], ``(batch, n_components)``, float32.
    """
    scanner = scanner_of(episodes, agent)
    if scanner is None:
        ranges = graph.input("ranges", np.float32, 0)
    else:
        options, readings, _ = scanner
        ranges = cleaned(graph.input("ranges", np.float32, readings.shape[1]), options.range_min, options.range_max)
    pose, goal = (graph.input(name, np.float64, 3) for name in ("pose", "goal"))
    velocity = graph.input("velocity", np.float64, int(episodes.action_sizes[agent]))
    elapsed, bodies = graph.input("elapsed", np.float64, 1), graph.input("bodies", np.float64, "n_bodies", 5)
    return RobotValues(graph, ranges, pose, velocity, goal, elapsed, action, bodies)


def cleaned(ranges: Value, shortest: float, farthest: float) -> Value:
    """Return raw ranges as the simulator reports them: +inf and NaN as no return, -inf and less as the shortest."""
    return (~ranges.is_nan()).where(ranges, farthest).between(shortest, farthest)
