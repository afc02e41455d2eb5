"""Omnidirectional drive with rotation."""

from collections.abc import Iterator
from typing import ClassVar

from irsim_gym.bodies.drives import motion_noise
from irsim_gym.bodies.drives.motion_noise import Variances
from irsim_gym.bodies.drives.omni import OmniMotion
from irsim_gym.simulator.world.names import OMNI_ANGULAR, kind, option


@kind
class OmniAngular(OmniMotion):
    """Moves in any direction while turning; command: forward, left [m/s] and angular velocity [rad/s]."""

    command_names: ClassVar[tuple[str, ...]] = ("forward", "left", "angular")
    command_words: ClassVar[tuple[tuple[str, str], ...]] = (
        ("speed ahead", "m/s"),
        ("speed to the left", "m/s"),
        ("turn rate, positive to the left", "rad/s"),
    )
    mirrored_command: ClassVar[tuple[tuple[int, int], ...]] = ((0, 1), (1, -1), (2, -1))
    drive: ClassVar[int] = OMNI_ANGULAR

    alpha: tuple[float, float, float] = option(
        (0.03, 0.03, 0.03), unit="m2/s2, m2/s2, rad2/s2", meaning="Variances of the three components."
    )

    @property
    def variances(self) -> Variances:
        """What the motion noise of the components depends on."""
        return motion_noise.constant(self.alpha)

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from motion_noise.negative_variances(self.alpha)
