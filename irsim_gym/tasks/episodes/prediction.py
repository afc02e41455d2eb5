"""The predictor: what agents will see when their next command acts, some time after they have measured.

Each agent's pose is rolled forward through its commands that are still under way, and the points of its scan are turned
into that pose. What moves by itself is seen where it was. ``irsim_gym.robot.prediction`` does the same in a graph.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from irsim_gym.base.families import DISTURBANCES
from irsim_gym.simulator.contact.contact import fill
from irsim_gym.simulator.engine.own_scans import RANGES, own_scan
from irsim_gym.simulator.geometry.angles import TURN, nearly_arctan2
from irsim_gym.simulator.step import outlines
from irsim_gym.simulator.step.disturbances import copy_rows
from irsim_gym.simulator.world.disturbed import Disturbed, whole_steps
from irsim_gym.simulator.world.group import Group
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, OMNI_ANGULAR, OMNI_WORLD
from irsim_gym.simulator.world.own_scan import OwnScan
from irsim_gym.tasks.definition.task import Task
from irsim_gym.tasks.terms import (
    EpisodeState,
    Floats,
    Ints,
    Model,
    Rays,
    Shard,
    Simulation,
    State,
    Struct,
    Term,
    kernel,
    row_of,
)
from irsim_gym.tasks.terms.term import HasArrays

NEAR_EDGE = 1e-4
"""A point that is nearer to the edge between two beams, as a share of their distance, is tested for both."""


@dataclass
class UnderWay(Struct):
    """The agents' latest commands, and where they lead.

    Attributes:
        agents: Body of each agent, shape ``(n_agents,)``.
        steers: Whether its second command is a steering angle, likewise.
        delay: How long each new command takes to act [s], shape ``(n_worlds, n_agents)``.
        sent: The latest commands in drive coordinates, shape ``(n_worlds, n_agents, n_kept, 3)``; the index of one is
            the step that it was sent for, modulo ``n_kept``.
        way: Where the agents will be, seen from where they are [m, m, rad], shape ``(n_worlds, n_agents, 3)``.
    """

    agents: Ints
    steers: Ints
    delay: Floats
    sent: Floats
    way: Floats


@dataclass
class Beams(Struct):
    """The beams of the agents' range sensors.

    Attributes:
        sensors: Number of each sensor in its group, shape ``(n,)``.
        agents: Whose it is, likewise.
        measured: Live readings [m], shape ``(n_worlds, n_sensors, n_beams)``.
        predicted: The readings that they are turned into, likewise.
        ahead: Cosines and sines of the beams' directions in the body frame, shape ``(n, 2, n_beams)``.
        edges: The same of the angles between which the beams look, shape ``(n, 2, n_beams + 1)``.
        first: The first of these angles [rad], shape ``(n,)``.
        step: Angle from beam to beam [rad].
        mount: Positions in the body frame [m], shape ``(n, 2)``.
        limits: Least and greatest reading [m], shape ``(n, 2)``.
    """

    sensors: Ints
    agents: Ints
    measured: Rays
    predicted: Rays
    ahead: Rays
    edges: Rays
    first: Floats
    step: float
    mount: Rays
    limits: Rays


class Predictor:
    """Shows observations the worlds as they will be for the agents when the next commands act.

    Args:
        simulation: The worlds.
        task: The task; its ``predict`` says when that is.

    Attributes:
        state: The state with the agents' predicted poses and velocities, and what follows from these.
    """

    def __init__(self, simulation: Simulation, task: Task) -> None:
        self._measured, self._model = simulation.state, simulation.model
        agents, told = np.array(task.agents, np.int64), 0.0 if task.predict is True else float(task.predict)
        sees_bodies = any("bodies" in (item.needs or ()) for item in task.observations)
        others = ("pose", "twist", "discs", "segments") if sees_bodies else ()
        names = {"pose", "direction", "velocity", "goal_distance", "twist", *others}
        self.state = replace(simulation.state, **{name: getattr(simulation.state, name).copy() for name in names})
        self._others = [
            (np.arange(now.shape[1]), now, getattr(self.state, name))
            for name in others
            if (now := getattr(simulation.state, name)).shape[1]
        ]
        latency = DISTURBANCES.entry("latency").kind
        groups = [group for group in simulation.parts.disturbances.groups if group.kind is latency and not told]
        self._delays = [(group.tables, _places(group.members, agents)) for group in groups]
        longest = told + sum(float(tables.high.max()) for tables, _ in self._delays)
        shape = (simulation.n_worlds, len(agents))
        self._under_way = UnderWay(
            agents=agents,
            steers=np.array([_steers(simulation, int(b)) for b in agents], np.int64),
            delay=np.full(shape, told),
            sent=np.zeros((*shape, whole_steps(longest, float(simulation.model.step_time[0])) + 1, 3)),
            way=np.zeros((*shape, 3)),
        )
        sensors = [_predicted(group) if RANGES in group.arrays else group for group in simulation.sensors]
        self._simulation = replace(simulation, state=self.state, parts=replace(simulation.parts, sensors=sensors))
        pairs = zip(simulation.sensors, sensors, strict=True)
        self._beams = [_beams(simulation, agents, *pair) for pair in pairs if pair[0] is not pair[1]]

    def show(self, terms: Sequence[Term]) -> None:
        """Let observations read predicted ranges; maps are kept, and ways found on them, where the agents are."""
        for term in terms:
            if "grid" in term.options.needs:
                term.measured = self._measured
            elif isinstance(term.options, HasArrays):
                term.arrays = term.options.arrays(self._simulation, term.agents)

    def look_ahead(self, episode: EpisodeState, shard: Shard) -> None:
        """Take note of the latest commands, and predict."""
        worlds, under_way, model, measured = shard.worlds, self._under_way, self._model, self._measured
        for rows in self._others:
            copy_rows(worlds, *rows)
        if self._delays:
            fill(worlds, 0.0, under_way.delay)
        for disturbed, places in self._delays:
            add_delays(worlds, disturbed, places, model, under_way.delay)
        roll_forward(worlds, under_way, model, measured, self.state, episode)
        if self._others:
            outlines.place(under_way.agents, model, self.state, shard)
        for beams in self._beams:
            turn_scans(worlds, beams, under_way)


def _places(bodies: Ints, agents: Ints) -> Ints:
    """Return which agent each body is, -1 for none."""
    return np.array([[*np.flatnonzero(agents == b), -1][0] for b in bodies], np.int64)


def _steers(simulation: Simulation, body: int) -> bool:
    """Return whether a body is a car whose second command is a steering angle."""
    drive = simulation.scenario.bodies[body].kinematics
    return bool(simulation.model.drive[body] == ACKERMANN and getattr(drive, "mode", "steer") == "steer")


def _predicted(sensors: Group) -> Group:
    """Return range sensors with readings of their own."""
    return replace(sensors, arrays={**sensors.arrays, RANGES: sensors.arrays[RANGES].copy()})


def _beams(simulation: Simulation, agents: Ints, group: Group, predicted: Group) -> Beams:
    """Return the beams of those sensors of a group that are the agents' first ones."""
    found = [(a, one[1]) for a, b in enumerate(agents) if (one := simulation.scan(int(b))) and one[0] is group]
    sensors, angles = np.array([k for _, k in found], np.int64), group.arrays["angles"]
    step = float(angles[-1] - angles[0]) / max(len(angles) - 1, 1)
    scan: OwnScan = own_scan(group, sensors)
    first = scan.angles[sensors, 0] - 0.5 * step
    # A point on an edge belongs to the beam that begins there, whatever is rounded.
    edges = first[:, None] + step * np.arange(len(angles) + 1) - 1e-12
    return Beams(
        sensors=sensors,
        agents=np.array([a for a, _ in found], np.int64),
        measured=scan.ranges,
        predicted=predicted.arrays[RANGES],
        ahead=np.stack([scan.beams_x[sensors], scan.beams_y[sensors]], axis=1).astype(np.float32),
        edges=np.stack([np.cos(edges), np.sin(edges)], axis=1).astype(np.float32),
        first=first,
        step=step,
        mount=scan.offset[sensors, :2].astype(np.float32),
        limits=np.stack([scan.range_min[sensors], scan.range_max[sensors]], axis=1).astype(np.float32),
    )


@kernel
def add_delays(worlds: Ints, disturbed: Disturbed, places: Ints, model: Model, delay: Floats) -> None:
    """Add the latency that levels have drawn.

    Reads: disturbed (values), model (step_time), delay.
    Writes: delay.

    Args:
        worlds: The worlds to treat.
        disturbed: The members of the disturbance.
        places: Which agent each member is, -1 for none.
        model: The constants.
        delay: Of each agent [s], shape ``(n_worlds, n_agents)``.
    """
    for w in worlds:
        for k in range(places.shape[0]):
            if places[k] >= 0:
                n = whole_steps(disturbed.values[w, k, 0], model.step_time[0])
                delay[w, places[k]] += n * model.step_time[0]


@kernel
def roll_forward(
    worlds: Ints, under_way: UnderWay, model: Model, state: State, seen: State, episode: EpisodeState
) -> None:
    """Note the latest commands, and write where those under way lead; limits of acceleration apply, a lag does not.

    Reads: under_way (agents, delay, sent, steers), model (acceleration_limit, drive, step_time, wheelbase), state
        (command, goal, pose, stopped, velocity), episode (steps).
    Writes: under_way (sent, way), seen (direction, goal_distance, pose, twist, velocity).
    """
    dt, n_kept = model.step_time[0], under_way.sent.shape[2]
    for w in worlds:
        sharpest = model.acceleration_limit[row_of(model.acceleration_limit, w)]
        for a in range(under_way.agents.shape[0]):
            b, newest, sent = under_way.agents[a], episode.steps[w, a], under_way.sent[w, a]
            pose, now, way = state.pose[w, b], seen.velocity[w, b], under_way.way[w, a]
            for axis in range(3):
                sent[newest % n_kept, axis] = state.command[w, b, axis]
                now[axis] = 0.0 if state.stopped[w, b] else state.velocity[w, b, axis]
                way[axis] = 0.0
            cosine, sine = np.cos(pose[2]), np.sin(pose[2])
            count = whole_steps(under_way.delay[w, a], dt)
            for k in range(count):
                span = dt if k > 0 else under_way.delay[w, a] - (count - 1) * dt
                number = newest - (count - 1 - k)
                for axis in range(3):
                    # Before the first command, the drive stands still.
                    asked, change = sent[number % n_kept, axis] if number > 0 else 0.0, sharpest[b, axis] * span
                    now[axis] += min(max(asked - now[axis], -change), change)
                ahead, left, rate = body_twist(now, cosine, sine, model, b, under_way.steers[a])
                middle = way[2] + 0.5 * span * rate
                way[0] += (ahead * np.cos(middle) - left * np.sin(middle)) * span
                way[1] += (ahead * np.sin(middle) + left * np.cos(middle)) * span
                way[2] += rate * span
            x, y = cosine * way[0] - sine * way[1], sine * way[0] + cosine * way[1]
            place, facing = seen.pose[w, b], seen.direction[w, b]
            place[0], place[1], place[2] = pose[0] + x, pose[1] + y, pose[2] + way[2]
            facing[0], facing[1], facing[2] = np.cos(place[2]), np.sin(place[2]), place[2]
            dx, dy = state.goal[w, b, 0] - place[0], state.goal[w, b, 1] - place[1]
            seen.goal_distance[w, b] = np.sqrt(dx * dx + dy * dy)
            seen.twist[w, b, 0] = ahead * facing[0] - left * facing[1]
            seen.twist[w, b, 1] = ahead * facing[1] + left * facing[0]


@kernel(inlined=True)
def body_twist(
    velocity: Floats, cosine: float, sine: float, model: Model, body: int, steers: int
) -> tuple[float, float, float]:
    """Return a velocity in drive coordinates in the body frame: ahead, to the left, and the turn rate.

    Reads: model (drive, wheelbase).
    """
    first, second, drive = velocity[0], velocity[1], model.drive[body]
    if drive == ACKERMANN and steers:
        return first, 0.0, first * np.tan(second) / model.wheelbase[body]
    if drive in (DIFFERENTIAL, ACKERMANN):
        return first, 0.0, second
    if drive == OMNI_WORLD:
        return cosine * first + sine * second, cosine * second - sine * first, 0.0
    return first, second, velocity[2] if drive == OMNI_ANGULAR else 0.0


@kernel
def turn_scans(worlds: Ints, beams: Beams, under_way: UnderWay) -> None:
    """Write the agents' scans as they will be.

    Reads: beams (agents, ahead, edges, first, limits, measured, mount, predicted, sensors, step), under_way (delay,
        way).
    Writes: beams (predicted).
    """
    for w in worlds:
        for n in range(beams.sensors.shape[0]):
            s, a = beams.sensors[n], beams.agents[n]
            scan, seen = beams.measured[w, s], beams.predicted[w, s]
            for k in range(scan.shape[0]):
                seen[k] = scan[k]
            if under_way.delay[w, a] > 0.0 and scan.shape[0] > 1:
                gather_points(scan, n, beams, under_way.way[w, a], seen)
                fill_gaps(beams.limits[n, 0], beams.limits[n, 1], seen)


@kernel
def gather_points(scan: Rays, n: int, beams: Beams, way: Floats, seen: Rays) -> None:
    """Write the distance of the nearest point of a scan that each beam sees after a move; infinity without one.

    Reads: beams (ahead, edges, first, limits, mount, step).

    Args:
        scan: The ranges [m], ``(n_beams,)``.
        n: Number of the sensor among ``beams``.
        beams: The beams.
        way: The move in the body frame [m, m, rad].
        seen: Written: the distances [m], likewise.
    """
    ahead, edges, mount, far = beams.ahead[n], beams.edges[n], beams.mount[n], beams.limits[n, 1]
    x, y, turn, per_turn = np.float32(way[0]), np.float32(way[1]), np.float32(way[2]), TURN / beams.step
    cosine, sine = np.cos(turn), np.sin(turn)
    seen[:] = np.inf
    for i in range(scan.shape[0]):
        at_x, at_y = scan[i] * ahead[0, i] + mount[0] - x, scan[i] * ahead[1, i] + mount[1] - y
        here_x, here_y = cosine * at_x + sine * at_y - mount[0], cosine * at_y - sine * at_x - mount[1]
        length = np.sqrt(here_x * here_x + here_y * here_y) if scan[i] < far else far
        place = (nearly_arctan2(here_y, here_x) - beams.first[n]) / beams.step
        # Scans of a full turn may begin where they end: then the beams at both ends see the same.
        for turns in range(-1, 2):
            near = place + turns * per_turn
            for k in range(
                max(int(np.floor(near - NEAR_EDGE)), 0), min(int(np.floor(near + NEAR_EDGE)) + 1, seen.size)
            ):
                if (
                    here_y * edges[0, k] - here_x * edges[1, k] >= 0.0
                    and here_y * edges[0, k + 1] - here_x * edges[1, k + 1] < 0.0
                ):
                    seen[k] = min(seen[k], length)


@kernel
def fill_gaps(least: np.float32, most: np.float32, seen: Rays) -> None:
    """Bring distances [m] between both limits; a beam that sees nothing reads what its neighbours do."""
    before = most
    for k in range(seen.shape[0]):
        after = min(max(seen[k + 1], least), most) if k + 1 < seen.shape[0] else most
        here = min(max(seen[k], least), most)
        seen[k] = here if seen[k] < np.inf else min(before, after)
        before = here
