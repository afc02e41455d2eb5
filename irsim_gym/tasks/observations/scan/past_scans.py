"""Past scans: earlier scans of the range sensor, transformed to the agent's current pose."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.simulator.geometry.angles import TURN, nearly_arctan2
from irsim_gym.simulator.world.names import Floats, Ints, Model, Rays, Shard, State, Struct, kernel, kind, option
from irsim_gym.tasks.observations.scan import ranges as readings
from irsim_gym.tasks.observations.scan.ranges import FAR_OFF, EncodesDepths, encode, range_code
from irsim_gym.tasks.terms import Bound, EpisodeState, Mirrored, Needs, Simulation, Term
from irsim_gym.tasks.terms.graph import RobotValues, Value, rotation, sector_minima
from irsim_gym.tasks.terms.mirrored import sectors_exchanged
from irsim_gym.tasks.terms.words import Columns, coded, evenly

LONGEST = 1000


@dataclass
class Memory(Struct):
    """Earlier scans, and the geometry of the sensors.

    Attributes:
        ranges: Live readings [m], shape ``(n_worlds, n_members, n_beams)``.
        members: Each agent's row in ``ranges``, shape ``(n_agents,)``.
        beams: Directions in the body frame, shape ``(n_agents, 2, n_beams)``.
        mount: Position of the sensor in the body frame [m], shape ``(n_agents, 2)``.
        reach: Radius of the disc that encloses the agent [m], shape ``(n_agents,)``.
        far: Maximum range [m], shape ``(n_agents,)``.
        ago: Ages of the observed scans [steps], shape ``(n_shown,)``.
        scans: The latest scans [m], shape ``(n_worlds, n_agents, n_kept, n_beams)``; the index of a scan is its step
            modulo ``n_kept``.
        poses: The poses at which they were taken [m, m, rad], shape ``(n_worlds, n_agents, n_kept, 3)``.
        ends: Scratch, see ``find_ends``, shape ``(n_slots, 2, n_beams)``.
    """

    ranges: Rays
    members: Ints
    beams: Floats
    mount: Floats
    reach: Floats
    far: Rays
    ago: Ints
    scans: Rays
    poses: Floats
    ends: Floats


@kind
class PastScans(EncodesDepths):
    """Earlier scans, transformed to the agent's current pose: free depth in sectors, encoded as in ``scan``.

    The points that were hit are transformed by the agent's own motion since then. Standing obstacles therefore read as
    in the present scan, and differences show motion, even to a policy without memory. While an episode is shorter than
    the age of a scan, its first scan is used.
    """

    needs: ClassVar[Needs] = ("scan", "odometry")

    ago: tuple[int, ...] = option((3, 6), unit="steps", meaning="Ages of the scans.")
    sectors: int = option(36, ge=1, le=1024, meaning="Number of sectors; the first begins straight behind.")
    without_sensor: str | tuple[str, ...] = readings.WITHOUT_SENSOR

    def problems(self) -> list[tuple[str, str]]:
        """Return key and message of conflicting options."""
        problems = readings.code_problems(self)
        if not self.ago or not all(1 <= steps <= LONGEST for steps in self.ago):
            problems.append(("ago", f"must be whole numbers from 1 to {LONGEST}, got {list(self.ago)}"))
        return problems

    def arrays(self, simulation: Simulation, agents: Ints) -> Memory:
        """Return the memory."""
        group, members = readings.shared_sensors(simulation, agents, "past_scans")
        table, mounts = group.arrays, [group.options[k] for k in members]
        turned = np.array([table["angles"] + mount.offset[2] for mount in mounts])
        shape = (simulation.n_worlds, len(agents), max(self.ago, default=0) + 1)
        return Memory(
            ranges=table["ranges"],
            members=members,
            beams=np.stack([np.cos(turned), np.sin(turned)], axis=1),
            mount=np.array([mount.offset[:2] for mount in mounts], np.float64),
            reach=simulation.model.reach[:, agents].max(axis=0),
            far=np.array([mount.range_max for mount in mounts], np.float32),
            ago=np.array(self.ago, np.int64),
            scans=np.zeros((*shape, len(table["angles"])), np.float32),
            poses=np.zeros((*shape, 3)),
            ends=np.zeros((simulation.shards.n_slots, 2, len(table["angles"]))),
        )

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the codes of the maximum depth and of contact."""
        return self.coded_bounds(term.arrays.far.max(), self.sectors * len(self.ago))

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        far = float(term.arrays.far[agent])
        scale = f"d = free depth beyond its reach, as {coded(self, 'd', far)}"
        sectors = evenly(self.sectors)
        return [
            Columns(f"scan of {steps} steps ago, seen from the current pose", scale, self.sectors, sectors)
            for steps in self.ago
        ]

    def mirrored(self, term: Term) -> Mirrored:
        """Return the sectors from right to left."""
        return sectors_exchanged(self.sectors, len(self.ago))

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph; see ``HasGraph``."""
        memory: Memory = term.arrays
        n_beams, oldest = memory.scans.shape[3], max(self.ago)
        # The present scan comes first. Where nothing is remembered yet (NaN), it takes the place of all earlier ones.
        scans = robot.graph.state("past_scans", np.full((oldest, n_beams), np.nan, np.float32))
        poses = robot.graph.state("past_poses", np.full((oldest, 3), np.nan))
        scan, pose = robot.ranges.spread(1), robot.pose.spread(1)
        scans = robot.graph.join([scan, scans.is_nan().where(scan, scans)])
        poses = robot.graph.join([pose, poses.is_nan().where(pose, poses)])
        robot.graph.keep("past_scans", scans.columns(0, oldest))
        robot.graph.keep("past_poses", poses.columns(0, oldest))
        scans, poses, far = scans.take(np.array(self.ago)), poses.take(np.array(self.ago)), memory.far[agent]
        reached = (scans < far).where(scans, FAR_OFF).cast(np.float64).spread(2)
        ends = reached * memory.beams[agent] + memory.mount[agent][:, None]
        # The way between two poses is a difference of large numbers: it comes first.
        moved = robot.turned(robot.ways(poses.columns(0, 2, 2))).spread(3)
        turns = rotation(poses.columns(2, 3, 2) - robot.pose.columns(2, 3).spread(2), len(self.ago))
        places = turns.times(ends) + moved
        depths = places.length(2, keeps=True) - memory.reach[agent]
        depths = sector_minima(depths, places, self.sectors).cast(np.float32)
        return self.coded_graph(far, depths.between(0.0, far)).op("Flatten")

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Store the present scan, and write the sectors of earlier ones."""
        note_scans(shard.worlds, term.agents, term.arrays, state, episode)
        write_past(shard.worlds, shard.slot, term.bound, term.arrays, state, episode)


@kernel
def note_scans(worlds: Ints, agents: Ints, memory: Memory, state: State, episode: EpisodeState) -> None:
    """Replace each agent's oldest scan and pose by the present ones.

    Reads: memory (members, ranges), state (pose), episode (steps).
    Writes: memory (poses, scans).
    """
    for w in worlds:
        for a in range(agents.shape[0]):
            slot = episode.steps[w, a] % memory.scans.shape[2]
            for k in range(memory.scans.shape[3]):
                memory.scans[w, a, slot, k] = memory.ranges[w, memory.members[a], k]
            for axis in range(3):
                memory.poses[w, a, slot, axis] = state.pose[w, agents[a], axis]


@kernel
def write_past(worlds: Ints, slot: int, term: Bound, memory: Memory, state: State, episode: EpisodeState) -> None:
    """Write the encoded depths of earlier scans.

    Reads: term (agents, column, options), memory (ago, beams, ends, far, mount, poses, reach, scans), state (pose),
        episode (observation, steps).
    Writes: memory (ends), episode (observation).
    """
    options, ago, ends = term.options[0], memory.ago, memory.ends[slot]
    sectors = options.sectors
    for w in worlds:
        for a in range(term.agents.shape[0]):
            newest, far, now = episode.steps[w, a], memory.far[a], state.pose[w, term.agents[a]]
            for j in range(ago.shape[0]):
                row_then = (newest - min(ago[j], newest)) % memory.scans.shape[2]
                column = term.column + j * sectors
                row = episode.observation[w, a, column : column + sectors]
                row[:] = far
                scan, then = memory.scans[w, a, row_then], memory.poses[w, a, row_then]
                find_ends(scan, then, now, memory.mount[a], memory.beams[a], ends)
                lower_depths(scan, ends, far, memory.reach[a], row)
                encode(row, range_code(options, far))


@kernel
def find_ends(scan: Rays, then: Floats, now: Floats, mount: Floats, beams: Floats, ends: Floats) -> None:
    """Write where the beams of a scan end, seen from another pose; the loop is vectorised.

    Args:
        scan: Ranges [m], ``(n_beams,)``.
        then: Pose of the body at the time of the scan [m, m, rad].
        now: Present pose of the body [m, m, rad].
        mount: Position of the sensor in the body frame [m].
        beams: Directions in the body frame, ``(2, n_beams)``.
        ends: Output: distance [m], and angle as a share of a turn from straight behind, ``(2, n_beams)``.
    """
    # The pose of then in the frame of now: rotation by ``turn``, origin at ``along``, ``aside``.
    turn = then[2] - now[2]
    cosine, sine = np.cos(turn), np.sin(turn)
    ahead, left = np.cos(now[2]), np.sin(now[2])
    dx, dy = then[0] - now[0], then[1] - now[1]
    along, aside = ahead * dx + left * dy, ahead * dy - left * dx
    for k in range(scan.shape[0]):
        x, y = mount[0] + scan[k] * beams[0, k], mount[1] + scan[k] * beams[1, k]
        there_x, there_y = along + cosine * x - sine * y, aside + sine * x + cosine * y
        ends[0, k] = np.sqrt(there_x * there_x + there_y * there_y)
        ends[1, k] = nearly_arctan2(there_y, there_x) / TURN + 0.5


@kernel
def lower_depths(scan: Rays, ends: Floats, far: np.float32, reach: float, row: Rays) -> None:
    """Lower the sectors' depths [m] to where the beams of a scan end.

    Args:
        scan: Ranges [m], ``(n_beams,)``.
        ends: Where the beams end, see ``find_ends``.
        far: Range from which a beam counts as having hit nothing [m].
        reach: Distance from the body's origin that is depth 0 [m].
        row: Output, ``(n_sectors,)``; the first sector begins straight behind.
    """
    n_sectors = row.shape[0]
    for k in range(scan.shape[0]):
        if scan[k] < far:
            # An angle of exactly pi, share 1, belongs to the first sector again.
            sector = int(ends[1, k] * n_sectors)
            sector = sector if sector < n_sectors else 0
            row[sector] = min(row[sector], np.float32(max(ends[0, k] - reach, 0.0)))
