"""The simulator: many worlds of one scenario, stepped together."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from irsim_gym.base import rng
from irsim_gym.base.errors import UnknownNameError, several, suggestion
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.contact import body_buckets, contact
from irsim_gym.simulator.engine import field_of_view
from irsim_gym.simulator.engine.collect import make_context
from irsim_gym.simulator.engine.given import check_bodies, check_commands, check_level
from irsim_gym.simulator.engine.world_marks import contact_marks, marks_of, track_marks
from irsim_gym.simulator.running.fused import Fused, Recordings, only_kernels
from irsim_gym.simulator.running.shards import Shards
from irsim_gym.simulator.step import disturbances, outlines, respawn, restart
from irsim_gym.simulator.step.parts import Parts
from irsim_gym.simulator.step.step import Orders, advance, refresh
from irsim_gym.simulator.tracks.tracker import Tracker
from irsim_gym.simulator.world.group import Group, Shard, WorldContext, find_sensor
from irsim_gym.simulator.world.names import Flags, Floats, Ints, Model, State, Words


@dataclass
class Simulation:
    """A compiled scenario.

    Attributes:
        scenario: What the file says.
        model: The episode's constants.
        state: State of the worlds.
        parts: Groups and index lists.
        agents: Bodies that are commanded from outside, shape ``(n_agents,)``.
        shards: The division of labour.
        fused: Steps are recorded and replayed as one call where that is possible; False for the plain path.
        trackers: What follows bodies in scans for learners; pictures show their tracks.
    """

    scenario: Scenario
    model: Model
    state: State
    parts: Parts
    agents: Ints
    shards: Shards
    fused: bool = True
    trackers: list[Tracker] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._recordings = Recordings()
        drawn = self.parts.maps, self.parts.footprints, self.parts.placements, self.parts.disturbances.outlines
        levels = [group.kind for groups in drawn for group in groups]
        self._advance = self.fuse(self.advance)
        self._draw = self.fuse(self._draw_level, levels)
        self._start = self.fuse(self._start_drawn)

    def __repr__(self) -> str:
        counts = (self.n_worlds, "world"), (len(self.scenario.robots), "robot"), (len(self.agents), "agent")
        return f"<Simulation {self.scenario.label}: {', '.join(several(*count) for count in counts)}>"

    def fuse(self, function: Callable[[Shard], None], kinds: Iterable[object] = ()) -> Fused:
        """Return a function of a shard as one compiled call, where it consists of kernels alone.

        Args:
            function: The plain path; it may advance the worlds by a step.
            kinds: Whom it calls, beside the kinds that act in a step of the simulation.
        """
        parts = self.parts
        groups = (*parts.group_behaviors, *parts.behaviors, *parts.kinematics, *parts.sensors)
        groups += tuple(parts.disturbances.groups)
        called = [*kinds, *(group.kind for group in groups)]
        is_fusable = self.fused and only_kernels(called)
        return self._recordings.add(function, called, is_fusable)

    def rewire(self) -> None:
        """Discard recorded steps, because arrays or lists of bodies were replaced."""
        self._recordings.forget()

    @property
    def n_worlds(self) -> int:
        """Number of worlds."""
        return len(self.state.time)

    @property
    def explored(self) -> Flags | None:
        """What the robots have seen, shape ``(n_worlds, columns, rows)``; None unless the file asks (``fog_map``)."""
        return None if self.parts.fog is None else self.parts.fog.cells.explored

    @property
    def told(self) -> State:
        """The state as robots know it: ``state`` itself, unless their odometry is disturbed."""
        belief = self.parts.disturbances.belief
        return self.state if belief is None else belief.state

    def marks(self, world: int) -> tuple[Any, ...]:
        """Return marks, for a renderer: believed outlines, blind sectors, tracks, and contacts that bodies feel."""
        parts = self.parts
        felt = contact_marks(parts.sensors, parts.pushing, world)
        tracks = track_marks(self.trackers, self.model, self.state, world)
        return (*marks_of(parts.disturbances, self.model, self.state, world), *tracks, *felt)

    @property
    def known(self) -> Model:
        """The constants as robots know them: ``model`` itself, unless their footprints are disturbed."""
        model = self.parts.disturbances.known
        return self.model if model is None else model

    @property
    def sensors(self) -> list[Group]:
        """Sensor groups with their readings."""
        return self.parts.sensors

    @property
    def context(self) -> WorldContext:
        """Specifications, sensors and fields of view of the bodies, for readers of single bodies."""
        return make_context(self.scenario, self.model, self.parts.sensors, self.parts.matter, self.parts.pushing)

    def body(self, name: str) -> int:
        """Return the index of a body.

        Raises:
            UnknownNameError: No body has that name.
        """
        names = self.parts.names
        if name not in names:
            raise UnknownNameError(f"no body named '{name}' in '{self.scenario.name}'{suggestion(name, names)}")
        return names.index(name)

    def sensor(self, body: int, reading: str, index: int = 0) -> tuple[Group, int] | None:
        """Return the group and the member number of one of a body's sensors with some reading, None without it.

        Args:
            body: The body.
            reading: What the sensor reads, such as ``"ranges"``.
            index: Which of these sensors, in the order of the file.
        """
        return find_sensor(self.scenario.bodies, self.parts.sensors, body, reading, index)

    def scan(self, body: int, index: int = 0) -> tuple[Group, int] | None:
        """Return the group and the member number of one of a body's range sensors, None without it.

        Args:
            body: Number of the body.
            index: Which of its range sensors, in the order of the file.
        """
        return self.sensor(body, "ranges", index)

    def detected(self, body: int, worlds: Ints | None = None) -> Flags:
        """Return which bodies are in a body's field of view now, shape ``(n_worlds, n_bodies)``.

        Other bodies count as discs, see ``simulator/engine/field_of_view.py``; nothing hides what is behind it.

        Args:
            body: The one that looks.
            worlds: The worlds to look at, indices of shape ``(n,)``, all by default; the rows of the others are False.

        Raises:
            UnknownNameError: The body has no field of view.
        """
        spec = self.scenario.bodies[body]
        if spec.fov is None or spec.fov_radius is None:
            raise UnknownNameError(f"'{self.parts.names[body]}' has no field of view: give it fov and fov_radius")
        seen = np.zeros(self.model.present.shape, np.bool_)
        chosen = np.arange(self.n_worlds, dtype=np.int64) if worlds is None else np.asarray(worlds, np.int64)
        field_of_view.detect(chosen, body, spec.fov, spec.fov_radius, self.model, self.state, seen)
        return seen

    def run(self, function: Callable[[Shard], None], worlds: Ints | None = None) -> None:
        """Call ``function`` with shards of the given worlds (all by default), on several threads if there are any.

        Args:
            worlds: Indices of the worlds, shape ``(n,)``.
        """
        self.shards.run(function, worlds)

    def run_beginning(self, function: Callable[[Shard], None], worlds: Ints | None = None) -> None:
        """Call a function that begins levels, see ``run``.

        Args:
            function: What is called with shares of the worlds.
            worlds: Indices of the worlds, shape ``(n,)``; None for all.

        Raises:
            PlacementError: A level could not be drawn.
        """
        for slot in range(self.shards.n_slots if self._recordings.kinds else 0):
            # Arrays are read-only while a promise is checked: no thread may draw a level then.
            self._draw.prepare(slot)
            self._start.prepare(slot)
        try:
            self.run(function, worlds)
        except RuntimeError:
            restart.check_drawn(self.parts, self.state, self.shards.all[0].worlds if worlds is None else worlds)
            raise

    def begin(self, shard: Shard, keys: Words) -> None:
        """Begin new levels in the shard's worlds, for ``run_beginning``.

        Args:
            keys: Keys of the levels, see ``level_keys``, shape ``(n_worlds,)``.
        """
        restart.note_streams(shard.worlds, keys, self.state.random, self.model)
        restart.begin(self.state, shard, self._draw, self._start)

    def _draw_level(self, shard: Shard) -> None:
        restart.draw_level(self.parts, self.model, self.state, shard)

    def _start_drawn(self, shard: Shard) -> None:
        restart.start_drawn(self.parts, self.model, self.state, shard)

    def advance(self, shard: Shard) -> None:
        """Advance the shard's worlds by one step."""
        advance(self.parts, self.model, self.state, shard)

    def vanish(self, shard: Shard, bodies: Ints, gone: Flags) -> None:
        """Remove bodies until another level or a respawn; ``gone`` says which, shape ``(n_worlds, n_bodies)``.

        Args:
            bodies: Numbers of the bodies, shape ``(n,)``.
        """
        respawn.vanish(bodies, gone, self.model, self.state, shard)

    def respawn(self, shard: Shard, bodies: Ints, chosen: Flags) -> None:
        """Let bodies start again at drawn poses while their worlds go on; ``chosen`` is as in ``vanish``.

        Args:
            bodies: Numbers of the bodies, shape ``(n,)``.

        Raises:
            PlacementError: There is no room for one of them.
        """
        respawn.respawn(self.parts, self.model, self.state, shard, bodies, chosen)

    def clearance(self, shard: Shard, bodies: Ints, distance: Floats, limit: float | Floats = np.inf) -> None:
        """Write the bodies' surface distances [m] into ``distance``, shape ``(n_worlds, n_bodies)``.

        Distances above ``limit``, a number or an array like ``distance`` (or that array itself), may be reported as
        the limit: the nearer it is, the fewer bodies have to be looked at.

        Args:
            bodies: Numbers of the bodies, shape ``(n,)``.
        """
        if not isinstance(limit, np.ndarray):
            contact.fill(shard.worlds, float(limit), distance)
            limit = distance
        movers = self.parts.movers
        only_mover = int(movers[0]) if len(movers) == 1 else contact.NOBODY
        contact.clearance(bodies, limit, self.model, self.state, shard, distance, only_mover)

    def reset(self, seed: int = 0, split: str = "train", episode: int = 0) -> None:
        """Begin an episode in all worlds.

        Args:
            seed: World ``w`` begins level ``seed + w`` of the split.
            split: ``"train"``, ``"dev"`` or ``"test"``.
            episode: Which one of the chain of levels that begins with that level.

        Raises:
            TypeError: The seed is no whole number.
            ValueError: It is negative, or larger than 64 bits can hold.
        """
        keys = self.level_keys(seed, split, episode)
        self.run_beginning(lambda shard: self.begin(shard, keys))

    def level_base(self, split: str) -> tuple[np.uint64, int]:
        """Return what the levels of a split are found by: their key and 0, or their first row in a file and its number.

        Raises:
            UnknownNameError: The levels come from a file that has other splits.
        """
        if self.scenario.levels is None:
            return rng.stream_base(self.scenario.name, split), 0
        first, count = self.scenario.levels.rows(split)
        return np.uint64(first), count

    def level_keys(self, seed: int, split: str = "train", episode: int = 0) -> Words:
        """Return what each world's level is taken from, ``(n_worlds,)``: a random stream, or a row of a file.

        Args:
            seed: World ``w`` begins level ``seed + w``.
            split: ``train``, ``dev`` or ``test``.
            episode: Number of the episode in each world since then, from 0.
        """
        base, count = self.level_base(split)
        first = check_level(seed, self.n_worlds)
        levels = [int(rng.later_level(first + w, episode)) for w in range(self.n_worlds)]
        return np.array([rng.level_key(base, count, level) for level in levels], np.uint64)

    def streams(self, seed: int) -> Words:
        """Return a random stream for each world, ``(n_worlds,)``: those that the drawn levels of a seed begin with."""
        base = rng.stream_base(self.scenario.name, "train")
        return np.array([rng.level_stream(base, int(seed) + w) for w in range(self.n_worlds)], np.uint64)

    def reset_to_start(self) -> None:
        """Begin the present level of each world again. The same commands give the same episode."""
        self.run_beginning(self._begin_again)

    def _begin_again(self, shard: Shard) -> None:
        altered = self.model.altered[shard.worlds]
        if altered.any():  # bodies that vanished or respawned are restored only by drawing the level again
            self.begin(Shard(shard.worlds[altered], shard.slot), self.model.level_stream.copy())
        restart.begin_again(self.parts, self.model, self.state, Shard(shard.worlds[~altered], shard.slot))

    def step(
        self, commands: Sequence[float] | Floats | None = None, bodies: Sequence[int] | Ints | None = None
    ) -> None:
        """Advance all worlds by one step.

        Args:
            commands: Commands of the agents, broadcast to ``(n_worlds, n_agents, n)`` in drive coordinates
                [m/s, rad/s]; by default those in ``state.command`` stay.
            bodies: Whom the commands are for in place of the agents, shape ``(n_bodies,)``: in this step alone
                they override what those bodies decide.

        Raises:
            ValueError: There is no such body or nobody to command, or the commands have a wrong shape.
        """
        if commands is None:
            self.run(self._advance)
            return
        chosen = self.agents if bodies is None else check_bodies(bodies, self.scenario)
        array = check_commands(commands, chosen, self.scenario, self.n_worlds)
        if bodies is not None:
            self._step_with(chosen, array)
            return
        self.state.command[:, self.agents, : array.shape[-1]] = array
        self.run(self._advance)

    def _step_with(self, bodies: Ints, commands: Floats) -> None:
        model, state = self.model, self.state
        orders = Orders(bodies, np.zeros((self.n_worlds, len(bodies), 3)))
        orders.commands[..., : commands.shape[-1]] = commands
        driven, earlier = model.driven[bodies], state.command[:, bodies]
        # For a body that nobody drives, ``limit_velocity`` would take a command of zeros as no command, and stop it at
        # once.
        model.driven[bodies] = True
        try:
            self.run(lambda shard: advance(self.parts, model, state, shard, orders))
        finally:
            model.driven[bodies], state.command[:, bodies] = driven, earlier

    def place(self, bodies: Ints) -> None:
        """Move bodies to the poses in ``state.pose``, with the velocities in ``state.velocity``.

        Outlines, twists and the contacts of bodies that never move are updated at once; flags and readings by the next
        step, or by ``refresh``.

        Args:
            bodies: Numbers of the bodies, shape ``(n,)``.
        """
        self.run(lambda shard: self._place(bodies, shard))

    def _place(self, bodies: Ints, shard: Shard) -> None:
        parts, model, state = self.parts, self.model, self.state
        outlines.place(bodies, model, state, shard)
        body_buckets.refresh(bodies, model, state, shard)
        for group in parts.kinematics:
            group.kind.begin(group, model, state, shard)
        disturbances.tell(parts.disturbances, bodies, state, shard)
        if np.isin(bodies, parts.fixed).any():
            # Flags of all bodies stay until the next step: only ``model.static_partner`` is to change.
            collided, hit = state.collided[shard.worlds], state.hit[shard.worlds]
            contact.find_static(parts.fixed, model, state, shard)
            state.collided[shard.worlds], state.hit[shard.worlds] = collided, hit

    def refresh(self) -> None:
        """Update outlines, flags and readings after poses were written from outside."""
        self.run(lambda shard: refresh(self.parts, self.model, self.state, shard))

    def uniform(self, low: Sequence[float], high: Sequence[float], world: int = 0) -> Floats:
        """Draw numbers from a world's random stream, each from its interval ``[low, high)``, shape ``(n,)``.

        Args:
            low: Lower ends, without unit, ``n`` of them.
            high: Upper ends, likewise.
            world: The world.
        """
        drawn = [rng.uniform(self.state.random, world, a, b) for a, b in zip(low, high, strict=True)]
        return np.array(drawn, np.float64)
