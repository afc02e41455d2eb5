"""The predictor: what agents will see when their next command acts, some time after they have measured.

Each agent's pose is rolled forward through its commands that are still under way, and the points of its scan are turned
into that pose. What moves by itself is seen where it was. ``irsim_gym.robot.prediction`` does the same in a graph.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from irsim_gym.base.families import DISTURBANCES
from irsim_gym.simulator.engine.own_scans import RANGES, own_scan
from irsim_gym.simulator.geometry.angles import TURN, nearly_arctan2
from irsim_gym.simulator.step import outlines
from irsim_gym.simulator.step.disturbances import copy_rows
from irsim_gym.simulator.world.disturbed import Disturbed, whole_steps
from irsim_gym.simulator.world.names import ACKERMANN, Floats, Ints, Model, Rays, Shard, State, Struct, kernel, row_of
from irsim_gym.simulator.world.own_scan import OwnScan
from irsim_gym.simulator.world.twist import body_twist
from irsim_gym.tasks.definition.task import Task
from irsim_gym.tasks.terms import EpisodeState, HasArrays, Simulation, Term

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
class SeenBeams(Struct):
    """The agents' scans, as they are and as they will be.

    Attributes:
        scan: The scans that are measured.
        agents: Whose each of them is, shape ``(n,)``.
        edges: Cosines and sines of the angles between which the beams look, shape ``(n, 2, n_beams + 1)``.
        ranges: The readings that are predicted [m], shape ``(n_worlds, n_sensors, n_beams)``.
    """

    scan: OwnScan
    agents: Ints
    edges: Rays
    ranges: Rays


class Predictor:
    """Shows observations the worlds as they will be for the agents when the next commands act.

    Args:
        simulation: The worlds.
        task: The task; its ``predict`` says when that is.

    Attributes:
        state: The state with the agents' predicted poses and velocities, and what follows from these.
    """

    def __init__(self, simulation: Simulation, task: Task) -> None:
        self._measured, self._model, dt = simulation.told, simulation.model, float(simulation.model.step_time[0])
        of_bodies = ("pose", "twist", "discs", "segments")
        names = *of_bodies, "direction", "velocity", "goal_distance"
        copies = {name: getattr(simulation.told, name).copy() for name in names}
        self.state = replace(simulation.state, **copies)
        sees_bodies = any("bodies" in (item.needs or ()) for item in task.observations)
        pairs = [(getattr(simulation.state, name), copies[name]) for name in of_bodies if sees_bodies]
        self._others = [(np.arange(rows.shape[1]), rows, copied) for rows, copied in pairs]
        agents, told = np.array(task.agents, np.int64), 0.0 if task.predict is True else float(task.predict)
        found = simulation.parts.disturbances.groups if task.predict is True else []
        self._latencies = [group.tables for group in found if group.kind is DISTURBANCES.entry("latency").kind]
        most = whole_steps(told, dt) + sum(int(np.ceil(latency.high / dt).sum()) for latency in self._latencies)
        shape = (simulation.n_worlds, len(agents))
        steered = np.array([steers(simulation, int(b)) for b in agents], np.int64)
        sent, way = np.zeros((*shape, most + 1, 3)), np.zeros((*shape, 3))
        self._under_way = UnderWay(agents=agents, steers=steered, delay=np.full(shape, told), sent=sent, way=way)
        sensors, self._beams = list(simulation.sensors), []
        for i, group in enumerate(sensors):
            own = [(a, one[1]) for a, b in enumerate(agents) if (one := simulation.scan(int(b))) and one[0] is group]
            if own:
                sensors[i] = replace(group, arrays={**group.arrays, RANGES: group.arrays[RANGES].copy()})
                whose, members = np.array(own, np.int64).T.copy()
                scan: OwnScan = own_scan(group, members)
                edges = beam_edges(scan.angles[members])
                self._beams.append(SeenBeams(scan, whose, edges, sensors[i].arrays[RANGES]))
        self._simulation = replace(simulation, state=self.state, parts=replace(simulation.parts, sensors=sensors))

    def show(self, terms: Sequence[Term]) -> None:
        """Let observations read predicted ranges; maps are kept, and ways found on them, where the agents are."""
        for term in terms:
            if "grid" in term.options.needs:
                term.measured = self._measured
            elif isinstance(term.options, HasArrays):
                term.arrays = term.options.arrays(self._simulation, term.agents)

    def look_ahead(self, episode: EpisodeState, shard: Shard) -> None:
        """Take note of the latest commands, and predict."""
        for rows in self._others:
            copy_rows(shard.worlds, *rows)
        for latency in self._latencies:
            write_delays(shard.worlds, latency, self._under_way, self._model)
        roll_forward(shard.worlds, self._under_way, self._model, self._measured, self.state, episode)
        if self._others:
            outlines.place(self._under_way.agents, self._model, self.state, shard)
        for beams in self._beams:
            turn_scans(shard.worlds, beams, self._under_way)


def steers(simulation: Simulation, body: int) -> bool:
    """Return whether a body is a car whose second command is a steering angle."""
    drive = simulation.scenario.bodies[body].kinematics
    return bool(simulation.model.drive[body] == ACKERMANN and getattr(drive, "mode", "steer") == "steer")


def beam_edges(angles: Floats) -> Rays:
    """Return cosines and sines of the angles between which beams of even steps look, ``(n, 2, n_beams + 1)``.

    Args:
        angles: Directions of the beams [rad], ``(n, n_beams)``.
    """
    n_beams = angles.shape[1]
    step = (angles[:, -1:] - angles[:, :1]) / max(n_beams - 1, 1)
    # A point on an edge belongs to the beam that begins there, whatever is rounded.
    edges = angles[:, :1] + step * (np.arange(n_beams + 1) - 0.5) - 1e-12
    return np.stack([np.cos(edges), np.sin(edges)], axis=1).astype(np.float32)


@kernel
def write_delays(worlds: Ints, latency: Disturbed, under_way: UnderWay, model: Model) -> None:
    """Write the latency that levels have drawn for the agents among its members, in whole steps.

    Reads: latency (members, values), under_way (agents), model (step_time).
    Writes: under_way (delay).
    """
    for w in worlds:
        for a in range(under_way.agents.shape[0]):
            n_steps, is_late = 0, False
            for k in range(latency.members.shape[0]):
                if latency.members[k] == under_way.agents[a]:
                    n_steps, is_late = n_steps + whole_steps(latency.values[w, k, 0], model.step_time[0]), True
            if is_late:
                under_way.delay[w, a] = n_steps * model.step_time[0]


@kernel
def roll_forward(
    worlds: Ints, under_way: UnderWay, model: Model, state: State, seen: State, episode: EpisodeState
) -> None:
    """Note the latest commands, and write where those under way lead; limits of acceleration apply, a lag does not.

    Reads: under_way (agents, delay, sent, steers, way), model (acceleration_limit, drive, step_time, wheelbase), state
        (command, goal, pose, stopped, velocity), seen (direction, pose, velocity), episode (steps).
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
            wheelbase = model.wheelbase[b] if under_way.steers[a] else 0.0
            count = whole_steps(under_way.delay[w, a], dt)
            for k in range(count):
                span = dt if k > 0 else under_way.delay[w, a] - (count - 1) * dt
                number = newest - (count - 1 - k)
                for axis in range(3):
                    # Before the first command, the drive stands still.
                    asked, change = sent[number % n_kept, axis] if number > 0 else 0.0, sharpest[b, axis] * span
                    now[axis] += min(max(asked - now[axis], -change), change)
                ahead, left, rate = body_twist(now, now[1], cosine, sine, model.drive[b], wheelbase)
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


@kernel
def turn_scans(worlds: Ints, beams: SeenBeams, under_way: UnderWay) -> None:
    """Write the agents' scans as they will be.

    Reads: beams (agents, edges, ranges, scan), under_way (delay, way).
    Writes: beams (ranges).
    """
    for w in worlds:
        for n in range(beams.agents.shape[0]):
            s, a = beams.scan.sensors[n], beams.agents[n]
            measured, seen = beams.scan.ranges[w, s], beams.ranges[w, s]
            for k in range(measured.shape[0]):
                seen[k] = measured[k]
            if under_way.delay[w, a] > 0.0 and measured.shape[0] > 1:
                gather_points(measured, beams.scan, s, beams.edges[n], under_way.way[w, a], seen)
                fill_gaps(np.float32(beams.scan.range_min[s]), np.float32(beams.scan.range_max[s]), seen)


@kernel
def gather_points(measured: Rays, scan: OwnScan, s: int, edges: Rays, way: Floats, seen: Rays) -> None:
    """Write the distance of the nearest point of a scan that each beam sees after a move; infinity without one.

    Reads: scan (angles, beams_x, beams_y, offset, range_max).
    Writes: seen.

    Args:
        measured: The ranges [m], ``(n_beams,)``.
        scan: The sensors.
        s: Number of the sensor.
        edges: Of its beams, see ``beam_edges``, ``(2, n_beams + 1)``.
        way: The move in the body frame [m, m, rad].
        seen: The distances [m], ``(n_beams,)``.
    """
    far, mount_x, mount_y = np.float32(scan.range_max[s]), np.float32(scan.offset[s, 0]), np.float32(scan.offset[s, 1])
    x, y, turn, n_beams = np.float32(way[0]), np.float32(way[1]), np.float32(way[2]), seen.shape[0]
    cosine, sine, first = np.cos(turn), np.sin(turn), scan.angles[s, 0]
    per_angle = (n_beams - 1) / (scan.angles[s, n_beams - 1] - first)
    seen[:] = np.inf
    for i in range(n_beams):
        at_x = measured[i] * np.float32(scan.beams_x[s, i]) + mount_x - x
        at_y = measured[i] * np.float32(scan.beams_y[s, i]) + mount_y - y
        here_x, here_y = cosine * at_x + sine * at_y - mount_x, cosine * at_y - sine * at_x - mount_y
        length = np.sqrt(here_x * here_x + here_y * here_y) if measured[i] < far else far
        place = (nearly_arctan2(here_y, here_x) - first) * per_angle + 0.5
        # Scans of a full turn may begin where they end: then the beams at both ends see the same.
        for turns in range(-1, 2):
            near = place + turns * TURN * per_angle
            if not -NEAR_EDGE <= near < n_beams + NEAR_EDGE:
                continue
            for k in range(max(int(near - NEAR_EDGE), 0), min(int(near + NEAR_EDGE) + 1, n_beams)):
                begun = here_y * edges[0, k] - here_x * edges[1, k] >= 0.0
                if begun and here_y * edges[0, k + 1] - here_x * edges[1, k + 1] < 0.0:
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
