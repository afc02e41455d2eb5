"""Common parts of observations of a range sensor: the agents' sensors, and the encoding of depths."""

from typing import Any, ClassVar, Literal, NamedTuple, Self, get_args

import numpy as np

from irsim_gym.simulator.world.names import Group
from irsim_gym.tasks.observations.scan.blind_sensor import blind_sensors
from irsim_gym.tasks.terms import Ints, Rays, Simulation, Value, kernel, kind, option

Code = Literal["inverse", "linear"]
INVERSE, LINEAR = 0, 1
FAR_OFF = 1e6
"""Where beams that hit nothing end in graphs [m]."""

WITHOUT_SENSOR = option(
    "",
    meaning="If a learner has no sensor: an observation, or a list, to use instead, with their defaults; 'nothing' "
    "keeps this one, as a sensor without beams shows it.",
)


@kind
class EncodesDepths:
    """The options of observations whose numbers are encoded distances.

    For a distance ``d``, ``inverse`` is ``(1 / (d + near) - zero) / (1 / near - zero)``: 1 in contact, steep at small
    distances, and about 0 at ``1 / zero``. ``linear`` is 1 in contact and 0 at the farthest distance.
    """

    needs_goal: ClassVar[bool] = False

    code: Code = option("inverse", meaning="How to encode a distance; see scan.")
    near: float = option(0.5, gt=0.0, unit="m", meaning="With code inverse, where the slope is half its maximum.")
    zero: float = option(0.3, ge=0.0, unit="1/m", meaning="Code inverse: value of 1 / (d + near) that becomes 0.")

    def coded_bounds(self, far: float, width: int) -> tuple[Rays, Rays]:
        """Return the codes of a distance [m] and of contact, shape ``(width,)`` each."""
        low, high = np.full(width, far, np.float32), np.zeros(width, np.float32)
        for values in (low, high):
            encode(values, RangeCode.of(self, far))
        return low, high

    def coded_graph(self, far: float, depths: Value) -> Value:
        """Return what ``encode`` makes of depths [m] of at most ``far``, of any shape, float32."""
        code = RangeCode.of(self, far)
        if code.number == INVERSE:
            contact = np.float32(1.0) / code.near - code.zero
            return (1.0 / contact) / (depths + code.near) - code.zero / contact
        return 1.0 - depths / code.far


class RangeCode(NamedTuple):
    """How depths become numbers.

    Attributes:
        number: ``INVERSE`` or ``LINEAR``.
        near: Inverse: the depth [m] at which the slope is half its maximum.
        zero: Inverse: the value of 1 / (depth + near) that becomes 0 [1/m].
        far: Linear: the depth [m] that becomes 0.
    """

    number: int
    near: np.float32
    zero: np.float32
    far: np.float32

    @classmethod
    def of(cls, options: Any, far: float) -> Self:
        """Return the code that an observation's options name, for depths up to ``far`` [m]."""
        return cls(code_number(options.code), np.float32(options.near), np.float32(options.zero), np.float32(far))


@kernel(inlined=True)
def range_code(options: Any, far: float) -> RangeCode:
    """Return what ``RangeCode.of`` returns, for options as kernels read them."""
    return RangeCode(options.code, np.float32(options.near), np.float32(options.zero), np.float32(far))


def code_number(code: str) -> int:
    """Return the number of a code in kernels."""
    return get_args(Code).index(code)


def code_problems(options: EncodesDepths) -> list[tuple[str, str]]:
    """Return key and message of conflicts between ``code``, ``near`` and ``zero``."""
    if options.code == "inverse" and options.zero * options.near > 0.5:
        return [("zero", f"must be <= 0.5 / near = {0.5 / options.near:g}, got {options.zero:g}")]
    return []


def shared_sensors(simulation: Simulation, agents: Ints, name: str) -> tuple[Group, Ints]:
    """Return the group of the agents' range sensors, and each agent's member of it.

    If an agent has several range sensors, the first one in the file is used. If no agent has one, the sensors have
    no beams: ``without_sensor: nothing``.

    Raises:
        ValueError: If some agents have no range sensor, or the sensors differ in their beams or in having noise.
    """
    sensors = [simulation.scan(int(b)) for b in agents]
    if not any(sensors):
        return blind_sensors(simulation, agents)
    groups = [item[0] for item in sensors if item is not None]
    if len(groups) < len(sensors) or any(group is not groups[0] for group in groups):
        raise ValueError(f"observation '{name}': all learners need range sensors of one kind with the same beams")
    return groups[0], np.array([item[1] for item in sensors if item is not None], np.int64)


@kernel(inlined=True)
def encode(row: Rays, code: RangeCode) -> None:
    """Replace depths [m] by their codes, in place; the float32 codes decrease monotonically with the depth."""
    for s in range(row.shape[0]):
        row[s] = encoded(row[s], code)


@kernel(inlined=True)
def encoded(depth: np.float32, code: RangeCode) -> np.float32:
    """Return the code of a depth [m]."""
    unit = np.float32(1.0)
    if code.number == INVERSE:
        # 1 in contact (depth 0), 0 at the depth of 1 / zero - near.
        return (unit / (depth + code.near) - code.zero) / (unit / code.near - code.zero)
    return unit - depth / code.far
