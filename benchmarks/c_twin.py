"""S1 in C (twin/s1.c), compiled with the system's compiler: the limit that our kernels are measured against."""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from standard_worlds import DIFF, TASK, s1

import irsim_gym as ig

HERE = Path(__file__).parent
SOURCE = HERE / "twin" / "s1.c"
FOLDER = HERE.parent / "build" / "twin"
FLAGS = ("-O3", "-march=native", "-ffast-math", "-fPIC")
WIDE = "-mprefer-vector-width=512"
"""Where it is known and the processor has such registers, gcc's loops are faster with it."""

BLOCK = 64
TABLES = ("disc_x", "disc_y", "disc_r", "ax", "ay", "dx", "dy", "per_square", "solid", "beams_x", "beams_y")
STATE = ("pose", "goal", "way", "path", "min_clearance", "steps", "random")
OUTCOMES = ("running", "success", "collision", "timeout")


class Room(ctypes.Structure):
    """What all worlds share; see twin/s1.c."""

    _fields_ = (
        *((name, ctypes.c_int64) for name in ("n_discs", "n_segments", "n_beams", "n_padded")),
        *((name, ctypes.c_void_p) for name in TABLES),
        *((name, ctypes.c_double) for name in ("side", "step_time", "radius", "range_max", "goal_threshold")),
        *((name, ctypes.c_double) for name in ("clearance", "least_way", "max_speed", "max_turn")),
        *((name, ctypes.c_double) for name in ("w_progress", "w_arrival", "w_collision", "w_time")),
        ("max_steps", ctypes.c_int64),
    )


class State(ctypes.Structure):
    """Where the robots are; see twin/s1.c."""

    _fields_ = tuple((name, ctypes.c_void_p) for name in STATE)


def compiler() -> str | None:
    """Return the command of a C compiler: ``CC``, clang, gcc or cc; None without any."""
    wanted = [os.environ.get("CC", ""), "clang", "gcc", "cc"]
    return next((found for name in wanted if name and (found := shutil.which(name))), None)


def library() -> ctypes.CDLL:
    """Compile the twin, unless that was done before, and load it.

    It is linked without ``-ffast-math``: with it, loading the library would make the whole process flush denormal
    numbers to 0.

    Raises:
        RuntimeError: There is no compiler, or it fails.
    """
    command = compiler()
    if command is None:
        raise RuntimeError("no C compiler found: set CC, or install clang or gcc")
    recipe = SOURCE.read_bytes() + " ".join((command, *FLAGS, "linked apart")).encode()
    key = hashlib.blake2b(recipe, digest_size=8).hexdigest()
    file = FOLDER / f"s1-{key}.so"
    if not file.exists():
        FOLDER.mkdir(parents=True, exist_ok=True)
        draft, compiled = file.with_suffix(f".{os.getpid()}"), file.with_suffix(f".{os.getpid()}.o")
        for flags in ((*FLAGS, WIDE), FLAGS):
            made = _run(command, *flags, "-c", "-o", str(compiled), str(SOURCE))
            if made.returncode == 0:
                made = _run(command, "-shared", "-o", str(draft), str(compiled), "-lm")
                break
        if made.returncode != 0:
            raise RuntimeError(f"{command} failed: {made.stderr}")
        compiled.unlink()
        draft.replace(file)
    return ctypes.CDLL(str(file))


def _run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(arguments, capture_output=True, text=True, check=False)


class Twin:
    """A batch of S1 in C.

    Attributes:
        tables: What all worlds share, by names of twin/s1.c.
        observation: What the robots perceive, float32 ``(n_worlds, n_beams + 6)``.
        reward: ``(n_worlds,)``.
        ended: Index into ``OUTCOMES``, ``(n_worlds,)``.
        pose: ``(n_worlds, 3)`` [m, m, rad].
        goal: ``(n_worlds, 2)`` [m].
        way: Distance to the goal [m], ``(n_worlds,)``.
        path: Length of the path [m], ``(n_worlds,)``.
        min_clearance: Least clearance of the episode [m], ``(n_worlds,)``.
        steps: Steps of the episode, ``(n_worlds,)``.
    """

    def __init__(self, n_worlds: int) -> None:
        self.n_worlds = n_worlds
        self._library = library()
        self._room, self.tables = _room()
        self.pose, self.goal = np.zeros((n_worlds, 3)), np.zeros((n_worlds, 2))
        self.way, self.path, self.min_clearance = np.zeros((3, n_worlds))
        self.steps = np.zeros(n_worlds, np.int64)
        self.random = np.arange(n_worlds, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
        self._state = State(*(getattr(self, name).ctypes.data for name in STATE))
        self.observation = np.zeros((n_worlds, self._room.n_beams + 6), np.float32)
        self.reward, self.ended = np.zeros(n_worlds), np.zeros(n_worlds, np.uint8)
        self._outputs = [ctypes.c_void_p(a.ctypes.data) for a in (self.observation, self.reward, self.ended)]
        self._fixed = ctypes.byref(self._room), ctypes.byref(self._state), ctypes.c_int64(n_worlds)
        self._library.twin_begin(*self._fixed, self._outputs[0])

    def step(self, actions: NDArray[np.float32], restarts: bool = True) -> None:
        """Advance all worlds by one step; with ``restarts`` ended ones begin anew.

        Args:
            actions: In [-1, 1], float32 and contiguous, shape ``(n_worlds, 2)``.
            restarts: Whether ended worlds begin anew at once.
        """
        given = ctypes.c_void_p(actions.ctypes.data)
        self._library.twin_step(*self._fixed, given, ctypes.c_int64(restarts), *self._outputs)


def _room() -> tuple[Room, dict[str, NDArray[Any]]]:
    """Return S1's room with the outlines as our own compiler of scenarios makes them, and the arrays it points to."""
    scenario = s1()
    simulation = ig.compile(ig.load_scenario(scenario), 1)
    simulation.reset(0)
    model, state = simulation.model, simulation.state
    discs, segments, solid = [], [], []
    for b in range(1, len(model.role)):
        discs += list(_rows(state.discs[0], model.disc_start[b], model.disc_count[0, b]))
        rows = _rows(state.segments[0], model.segment_start[b], model.segment_count[0, b])
        segments += list(rows)
        solid += [bool(model.solid[b])] * len(rows)
    (sensor,) = scenario["robot"][0]["sensors"]
    group = simulation.sensors[0]
    padded = -(-sensor["number"] // BLOCK) * BLOCK
    angles = np.zeros(padded)
    angles[: sensor["number"]] = group.arrays["angles"]
    rounds, ends = np.array(discs, np.float64).T.copy(), np.array(segments, np.float64).T.copy()
    extent = ends[2:] - ends[:2]
    arrays = [
        *rounds,
        *ends[:2],
        *extent,
        1.0 / np.sum(extent * extent, axis=0),
        np.array(solid, np.uint8),
        np.cos(angles).astype(np.float32),
        np.sin(angles).astype(np.float32),
    ]
    tables = dict(zip(TABLES, arrays, strict=True))
    side, place = scenario["world"]["width"], scenario["robot"][0]["distribution"]
    weights = {term["name"]: term["weight"] for term in TASK["rewards"]}
    room = Room(
        len(discs),
        len(segments),
        sensor["number"],
        padded,
        *(table.ctypes.data for table in tables.values()),
        side,
        scenario["world"]["step_time"],
        DIFF["shape"]["radius"],
        sensor["range_max"],
        DIFF["goal_threshold"],
        place["clearance"],
        place["min_goal_distance"],
        DIFF["vel_max"][0],
        DIFF["vel_max"][1],
        weights["progress"] / (side * np.sqrt(2.0)),
        weights["arrival"],
        weights["collision"],
        weights["time"] / TASK["max_steps"],
        TASK["max_steps"],
    )
    return room, tables


def _rows(table: NDArray[Any], start: int, count: int) -> NDArray[Any]:
    return table[start : start + count]
