"""From the start of a process to the first step, with nothing compiled and with everything compiled."""

from __future__ import annotations

import compileall
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from effort import Effort, Figures
from standard_worlds import s1, s2, s3
from timing import Timing, summed_up

import irsim_gym

FIRST_STEP = """
import json, sys
import irsim_gym
env = irsim_gym.make(json.loads(sys.argv[1]))
env.reset(seed=0)
env.step(env.action_space.sample())
"""
CROWD_STEP = """
import json, sys
import irsim_gym
simulation = irsim_gym.compile(irsim_gym.load_scenario(json.loads(sys.argv[1])), 1)
simulation.reset(0)
simulation.step()
"""

WARM_ROUNDS = 5
"""Processes with everything compiled; with nothing compiled there is one, for that takes long and hardly varies."""


def startup(effort: Effort) -> Figures:
    """Measure wall and CPU seconds of processes: import; first step, cold and warm; what lands on the disk.

    With little effort nothing is compiled, for that takes long. Byte code is there, as after an installation by pip.
    """
    compileall.compile_dir(Path(irsim_gym.__file__).parent, quiet=1)
    rounds = min(WARM_ROUNDS, effort.rounds)
    empty, imported = _process("pass", rounds), _process("import irsim_gym", rounds)
    figures: Figures = {
        "python_s": empty[0],
        "import_s": imported[0].least - empty[0].least,
        "import_cpu_s": imported[1].least - empty[1].least,
    }
    wanted: dict[str, tuple[str, Mapping[str, Any]]] = {
        "s1": (FIRST_STEP, s1()),
        "s3_cave": (FIRST_STEP, s3("cave")),
        "s2_orca": (CROWD_STEP, s2("orca")),
    }
    if effort.largest is not None:
        return figures
    for name, (code, scenario) in wanted.items():
        figures |= {f"{name}_{key}": value for key, value in _cold_and_warm(code, scenario, rounds).items()}
    return figures


def _cold_and_warm(code: str, scenario: Mapping[str, Any], rounds: int) -> Figures:
    with tempfile.TemporaryDirectory() as cache:
        cold = _process(code, 1, json.dumps(scenario), NUMBA_CACHE_DIR=cache)
        warm = _process(code, rounds, json.dumps(scenario), NUMBA_CACHE_DIR=cache)
        files = [file for file in Path(cache).rglob("*") if file.is_file()]
        return {
            "cold_first_step_s": cold[0].least,
            "cold_first_step_cpu_s": cold[1].least,
            "warm_first_step_s": warm[0],
            "warm_first_step_cpu_s": warm[1],
            "cache_kib": sum(file.stat().st_size for file in files) / 1024.0,
            "cached_kernels": sum(file.suffix == ".nbc" for file in files),
        }


def _process(code: str, rounds: int, *arguments: str, **environment: str) -> tuple[Timing, Timing]:
    """Return wall and CPU seconds of a process that runs some code."""
    walls, cpus = [], []
    for _ in range(rounds):
        begin, cpu = time.perf_counter(), _children_s()
        command = [sys.executable, "-c", code, *arguments]
        subprocess.run(command, check=True, capture_output=True, env={**os.environ, **environment})
        walls.append(time.perf_counter() - begin)
        cpus.append(_children_s() - cpu)
    return summed_up(walls), summed_up(cpus)


def _children_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
