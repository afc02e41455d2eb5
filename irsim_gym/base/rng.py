"""Random streams: one 64-bit counter per world, so that a batch draws what a single world draws.

The generator is SplitMix64 (Steele, Lea & Flood, "Fast splittable pseudorandom number generators",
OOPSLA 2014). A stream is keyed by (scenario, split, level); streams of different splits are disjoint
because the split enters the key through a cryptographic hash.
"""

import hashlib

import numpy as np

from irsim_gym.base.arraytypes import Words
from irsim_gym.base.kernels import kernel

STEP = np.uint64(0x9E3779B97F4A7C15)
MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
MIX_2 = np.uint64(0x94D049BB133111EB)
S27, S30, S31, S11 = np.uint64(27), np.uint64(30), np.uint64(31), np.uint64(11)
UNIT = 1.0 / 9007199254740992.0
LATER = np.int64(1) << np.int64(52)


def stream_base(scenario: str, split: str) -> np.uint64:
    """Return the key of all levels of one split of a scenario."""
    digest = hashlib.blake2b(f"{scenario}\0{split}".encode(), digest_size=8).digest()
    return np.uint64(int.from_bytes(digest, "little"))


@kernel
def mix(x: np.uint64) -> np.uint64:
    """Scramble 64 bits (the finaliser of SplitMix64)."""
    x = (x ^ (x >> S30)) * MIX_1
    x = (x ^ (x >> S27)) * MIX_2
    return x ^ (x >> S31)


@kernel
def level_stream(base: np.uint64, level: int) -> np.uint64:
    """Return the initial stream state of a level."""
    return mix(base ^ mix(np.uint64(level) + STEP))


@kernel
def level_key(base: np.uint64, count: int, level: int) -> np.uint64:
    """Return what a level is taken from: its random stream, or its row in a file, of ``count`` from ``base`` on."""
    if count > 0:
        return base + np.uint64(level % count)
    return level_stream(base, level)


@kernel
def later_level(first: int, episode: int) -> np.int64:
    """Return the level of a world's later episodes: it follows from the first level and the episode's number.

    Episode 0 is the first level itself; later ones lie between 2**52 and 2**53, out of reach of ordinary seeds.
    """
    if episode == 0:
        return np.int64(first)
    bits = mix(np.uint64(first) * STEP + np.uint64(episode))
    return np.int64(bits >> np.uint64(12)) | LATER


@kernel
def next_bits(random: Words, w: int) -> np.uint64:
    """Advance the stream of world ``w`` and return 64 bits."""
    random[w] = random[w] + STEP
    return mix(random[w])


@kernel
def uniform(random: Words, w: int, low: float, high: float) -> float:
    """Draw from [low, high), in the unit of these.

    Args:
        random: State of each world's stream, shape ``(n_worlds,)``: ``state.random``.
        w: The world.
        low: Lower end, in the [unit] of the number.
        high: Upper end, likewise; it is not drawn.
    """
    return low + (high - low) * (np.float64(next_bits(random, w) >> S11) * UNIT)


@kernel
def integer(random: Words, w: int, low: int, high: int) -> int:
    """Draw an integer.

    Args:
        random: State of each world's stream, shape ``(n_worlds,)``: ``state.random``.
        w: The world.
        low: The least.
        high: One more than the greatest.
    """
    return low + int(np.floor(uniform(random, w, 0.0, 1.0) * (high - low)))


@kernel
def normal(random: Words, w: int, mean: float, deviation: float) -> float:
    """Draw from a normal distribution (Box and Muller 1958; one of the pair is used), in the unit of the arguments.

    Args:
        random: State of each world's stream, shape ``(n_worlds,)``: ``state.random``.
        w: The world.
        mean: Mean, in the [unit] of the number.
        deviation: Standard deviation, likewise.
    """
    radius = np.sqrt(-2.0 * np.log(1.0 - uniform(random, w, 0.0, 1.0)))
    return mean + deviation * float(radius * np.cos(2.0 * np.pi * uniform(random, w, 0.0, 1.0)))
