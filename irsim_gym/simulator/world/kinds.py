"""What the kinds of a simulation have to have: a protocol for each family; those of a task are in ``tasks.terms.term``.

Methods that act in a step or in the beginning of an episode treat the worlds ``shard.worlds`` and leave all others
alone. They draw random numbers from ``state.random`` alone (``irsim_gym.base.rng``), world by world: then a
seed gives the same episode in any batch. What a kind remembers it keeps in ``group.arrays``, with the world as the
first axis.
"""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Protocol, runtime_checkable

from irsim_gym.base.arraytypes import Flags, Floats, Ints
from irsim_gym.base.contract import Contract
from irsim_gym.simulator.world.group import Group, Shard
from irsim_gym.simulator.world.model import Model
from irsim_gym.simulator.world.outline import Outline
from irsim_gym.simulator.world.response import Response
from irsim_gym.simulator.world.state import State


class DriveKind(Protocol):
    """How a body moves."""

    command_names: ClassVar[Annotated[tuple[str, ...], "names of the two or three numbers of a command"]]
    state_size: ClassVar[Annotated[int, "3, or 4 for a drive with a steering angle"]]

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Make room in ``group.arrays``.

        Args:
            n_slots: Threads that may work at once, each with a number, ``shard.slot``: scratch needs a row for each.
        """

    @staticmethod
    def begin(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' ``state.twist`` from ``state.pose`` and ``state.velocity``."""

    @staticmethod
    def move(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Advance ``state.pose`` of the members that are not stopped, by ``state.velocity``; write ``state.twist``."""


@runtime_checkable
class Steers(Protocol):
    """A drive that any behaviour for ``omni`` can command, such as dash, rvo, orca and sfm."""

    @staticmethod
    def steer(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Turn the members' velocities in the world frame [m/s], in ``state.command``, into commands of the drive."""


@runtime_checkable
class NamesCommand(Protocol):
    """A drive that says what the numbers of its command are."""

    command_words: ClassVar[Annotated[tuple[tuple[str, str], ...], "meaning and unit of each number of a command"]]


@runtime_checkable
class MirrorsCommand(Protocol):
    """A drive that says what its command becomes where left and right are exchanged, which ``mirror: true`` needs."""

    mirrored_command: ClassVar[
        Annotated[
            tuple[tuple[int, int], ...],
            "for each number of a command, the number that takes its place and the sign of that, such as "
            "((0, 1), (1, -1)) for a speed and a turn rate",
        ]
    ]


def mirror_problems(kind: type[Any]) -> Iterator[str]:
    """Yield what is wrong with the ``mirrored_command`` of a drive."""
    way, size = getattr(kind, "mirrored_command", ()), len(getattr(kind, "command_names", ()))
    if not isinstance(way, tuple) or not way:
        return
    if sorted(place for place, _ in way) != list(range(size)) or any(
        way[place] != (k, sign) or abs(sign) != 1 for k, (place, sign) in enumerate(way)
    ):
        yield (
            f"'mirrored_command' must name each of the {size} numbers of a command once, with 1 or -1, and change "
            f"nothing when it is applied twice, got {way}"
        )


class BehaviorKind(Protocol):
    """How a body, or a group of bodies, decides.

    ``kinematics``: names of the drives that it can command; without it, all.
    """

    reads_neighbors: ClassVar[Annotated[bool, "True if bodies decide and move one after another, else False"]]

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Make room in ``group.arrays``.

        Args:
            n_slots: Threads that may work at once, each with a number, ``shard.slot``: scratch needs a row for each.
        """

    @staticmethod
    def decide(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' ``state.command``; of a group, those that ``group.arrays["decides"]`` marks."""


@runtime_checkable
class ReadsScan(Protocol):
    """A behaviour that reads its own robot's scan: ``group.scan`` has those of its members (``OwnScan``).

    The members of its groups then read sensors with the same beams. A body without a range sensor is refused.
    """

    reads_scan: ClassVar[Annotated[bool, "True if its members need a range sensor, else False"]]


@runtime_checkable
class Begins(Protocol):
    """A behaviour or sensor that takes note of the start of an episode."""

    @staticmethod
    def begin(group: Group, shard: Shard) -> None:
        """Forget what is in ``group.arrays`` of the shard's worlds."""


@runtime_checkable
class Appears(Protocol):
    """A behaviour whose bodies come and go."""

    @staticmethod
    def appear(group: Group, model: Model, state: State, shard: Shard, ahead: int) -> None:
        """Write ``model.present`` of the members, and ``state.pose`` of who comes, at the time ``state.step + ahead``.

        It is called at the start of an episode with 0, and at the end of each step with 1, before contacts are found.
        """


class FootprintKind(Protocol):
    """What a body occupies."""

    is_random: ClassVar[Annotated[bool, "True if the outline is drawn anew for each level, else False"]]

    def outline(self) -> Outline:
        """Return the outline in the body frame; a random one at its largest."""


@runtime_checkable
class KeepsSymmetry(Protocol):
    """A footprint whose drawn outlines are symmetrical about the body's x axis if the largest one is."""

    keeps_symmetry: ClassVar[bool]


@runtime_checkable
class Draws(Protocol):
    """A footprint that is drawn anew for each level."""

    @staticmethod
    def draw(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' rows of ``model.local_segments`` or ``local_discs``, and ``model.reach``."""


class PlacementKind(Protocol):
    """Where the bodies of an entry start. It remembers nothing: a level follows from its random stream alone."""

    is_random: ClassVar[Annotated[bool, "True if levels differ, else False"]]
    roams: ClassVar[Annotated[bool, "True if it looks for room among what is placed already, else False"]]
    ensures_way: ClassVar[Annotated[bool, "True if each goal it draws can be reached, else False"]]
    gives_goal: ClassVar[Annotated[bool, "True if it writes model.waypoints[w, b], or n_goals of them, else False"]]

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> str | None:
        """Make room in ``group.arrays``; return what does not fit the world, or None.

        Args:
            n_slots: Threads that may work at once, each with a number, ``shard.slot``: scratch needs a row for each.
        """

    @staticmethod
    def draw(group: Group, model: Model, state: State, shard: Shard, failed: Ints) -> None:
        """Write ``state.pose`` and ``state.placed`` of the members that are present and not placed yet.

        Args:
            failed: 0, shape ``(n_worlds,)``; where a member b finds no place, ``failed[w]`` becomes b + 1, and the
                level is drawn anew.
        """


@runtime_checkable
class Confirms(Protocol):
    """A placement with ``ensures_way`` that proves the ways again once the level's last body is placed."""

    @staticmethod
    def confirm(group: Group, model: Model, state: State, shard: Shard, failed: Ints) -> None:
        """Set ``failed[w]`` to b + 1 where the way of a member b does not exist any more; the level is drawn anew."""


class MapKind(Protocol):
    """Which cells of the world are occupied: one map for all worlds, or one that each level draws."""

    is_random: ClassVar[Annotated[bool, "True if each level draws a map of its own, else False"]]

    def outline(self) -> Outline:
        """Return an outline without rows."""

    def occupied(self, width: float, height: float, name: str, find: Callable[[str], Path]) -> Flags:
        """Return which cells are occupied, shape ``(columns, rows)``; ``find`` returns the place of a named file.

        Where each level draws a map of its own, these are the cells that are occupied in every level, if any.

        Args:
            width: Width of the world [m].
            height: Height of the world [m].
            name: Name of the body, for messages.
        """


@runtime_checkable
class DrawsMaps(Protocol):
    """A map that each level draws anew."""

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Make room in ``group.arrays`` or ``group.tables``.

        Args:
            n_slots: Threads that may work at once, each with a number, ``shard.slot``: scratch needs a row for each.
        """

    @staticmethod
    def draw(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Make the maps of the shard's worlds, in ``model.cells``, with
        ``simulator.cell_maps.world_maps.lay_cells``.
        """


class SensorKind(Protocol):
    """What a body perceives."""

    reading: ClassVar[Annotated[str, "name of its reading in group.arrays, shape (n_worlds, n_members, ...)"]]

    def group_key(self) -> tuple[Any, ...]:
        """Return what members of one group have in common, such as the number of beams."""

    @staticmethod
    def prepare(group: Group, outlines: list[Outline], model: Model, n_slots: int) -> None:
        """Make room in ``group.arrays``, for the reading at least.

        Args:
            outlines: Outline of each body.
            n_slots: Threads that may work at once, each with a number, ``shard.slot``: scratch needs a row for each.
        """

    @staticmethod
    def sense(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' readings."""


@runtime_checkable
class Reports(Protocol):
    """A range sensor, whose scans are reported under IR-SIM's names."""

    def angles(self) -> Floats:
        """Return the beams' directions in the sensor frame [rad], shape ``(n_beams,)``."""

    @staticmethod
    def report(group: Group, member: int, world: int) -> dict[str, Any]:
        """Return a copy of a member's scan: ``angle_min``, ``angle_max``, ``ranges`` and so on.

        Args:
            member: Number of the member in the group.
            world: Number of the world.
        """

    @staticmethod
    def points(group: Group, member: int, world: int) -> Floats | None:
        """Return the points that the beams hit, in the sensor frame [m], shape ``(2, n)``; None without any.

        Args:
            member: Number of the member in the group.
            world: Number of the world.
        """


class DisturbanceKind(Protocol):
    """What makes a robot drive or measure otherwise than its entry says.

    Options of type ``base.options.Drawn`` are drawn for each level, between the ``Bounds`` that they are annotated
    with: ``group.tables``, a ``Disturbed``, has their values and a random stream for each member. It may have
    ``prepare``, as a drive has it, to make room in ``group.arrays``.
    """

    acts_on: ClassVar[
        Annotated[
            Literal["command", "motion", "belief", "outline", "mount", "scan"], "what it changes, see ``disturb``"
        ]
    ]

    @staticmethod
    def disturb(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Change something of the members, and count the call in ``group.tables.count``.

        ``command``: ``state.command``, before it is limited. ``motion``: ``state.velocity``, which the drive executes.
        ``belief``: ``state.pose``, which is the pose that the robot believes in, after its odometry has moved it;
        ``group.arrays["pose"]`` has the true ones. ``scan``: the ranges in ``group.scan``; a robot is a member once for
        each of its range sensors, whose true mount poses are in ``group.arrays["mounts"]``. ``mount``: these, where an
        episode begins. ``outline``: footprints in ``model``, before a level is placed.
        """


@runtime_checkable
class Foreseen(Protocol):
    """A disturbance of commands that shields reckon with.

    If it delays commands, they are in ``group.arrays["queue"]``, shape ``(n_worlds, n_members, n, 3)``.
    """

    @staticmethod
    def foresee(group: Group, model: Model, response: Response, shard: Shard) -> None:
        """Write into ``response`` what the drives of its members will still do; several disturbances act in turn."""


class ShieldKind(Protocol):
    """What stands between a learner's commands and its drive, and changes those that are not safe.

    ``group.scan`` has the scans of its members, those of the first range sensor of each.
    """

    @staticmethod
    def prepare(group: Group, response: Response, model: Model, n_slots: int) -> None:
        """Make room in ``group.arrays``.

        Args:
            response: What the drives of the members will still do; it is renewed before each call of ``shield``.
            n_slots: Threads that may work at once, each with a number, ``shard.slot``: scratch needs a row for each.
        """

    @staticmethod
    def shield(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Change the members' ``state.command``, and write whether into ``group.arrays["acted"]``, 0 or 1.

        Its shape is ``(n_worlds, n_learners)``; ``response.place`` says which of them a body is.
        """


DRIVE = Contract(DriveKind, (Steers, NamesCommand, MirrorsCommand), mirror_problems)
BEHAVIOR = Contract(BehaviorKind, (ReadsScan, Begins, Appears))
FOOTPRINT = Contract(FootprintKind, (Draws,))
PLACEMENT = Contract(PlacementKind, (Confirms,))
MAP = Contract(MapKind, (DrawsMaps,))
SENSOR = Contract(SensorKind, (Begins, Reports))
DISTURBANCE = Contract(DisturbanceKind, (Foreseen,))
SHIELD = Contract(ShieldKind)
