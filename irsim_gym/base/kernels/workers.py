"""Several processes compile what one is about to need.

A process that lacks several kernels lists them and starts workers, which get the same list. Each of them takes the
largest kernel that is neither on disk nor locked (``base.compiled.lock``), compiles it, and takes the next one. Workers
are programs of their own (``python -m irsim_gym.base.kernels.workers``), so a script needs no main guard, and threads,
daemons and forked children may start them. They live for one list: they end with their input, so also with the process
that holds its other end, however that ends. Where none can be started, the process compiles alone.
"""

import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from threading import Thread
from typing import IO, Any, NamedTuple

from irsim_gym.base.compiled.folder import cache_folder
from irsim_gym.base.compiled.key import functions_of
from irsim_gym.base.compiled.lock import lock
from irsim_gym.base.compiled.watch import compilation
from irsim_gym.base.kernels.decorator import Kernel

SWITCH = "IRSIM_GYM_COMPILERS"
"""The environment variable with the number of processes that compile; 1: no workers."""
MOST = 4
"""The default is the number of processors, and at most this: one large kernel takes a third of all the time."""
FEWEST = 4
"""Missing kernels for which a worker pays; it takes as long to start as five small ones to compile."""


class Job(NamedTuple):
    """A packed entry of a kernel, see ``PackedEntries.address``."""

    kernel: Kernel
    signature: tuple[Any, ...]
    layout: str

    @property
    def size(self) -> int:
        """Bytes of Python's code in the kernel and all that it calls: a measure of how long it takes to compile."""
        return sum(len(function.__code__.co_code) for function in functions_of(self.kernel.__wrapped__))

    def is_missing(self) -> bool:
        """Return whether the entry is not on disk."""
        return self.kernel.packed.is_missing(self.signature, self.layout)

    def compile(self, *, waits: bool) -> None:
        """Load or compile the entry; do nothing if another process compiles it and this one does not wait."""
        # An error is raised again, and explained, when the kernel is really needed.
        with suppress(Exception):
            self.kernel.packed.find(self.signature, self.layout, waits=waits)


def compile_together(jobs: Iterable[Job]) -> None:
    """Compile what is not on disk, with the help of workers where that pays, and load it."""
    missing = [job for job in dict.fromkeys(jobs) if job.is_missing()]
    if len(missing) < FEWEST:
        return
    missing.sort(key=lambda job: job.size, reverse=True)
    watch, received = compilation(), set(missing)
    with watch.expecting(_n_kernels(missing), lambda: len(kept_kernels())), _working(missing):
        for waits in (False, True):
            for job in missing:
                before = watch.compiled
                job.compile(waits=waits)
                if watch.compiled > before:
                    received.discard(job)
    watch.received += len(received)


def kept_kernels() -> list[str]:
    """Return the names of the files of compiled code, without the digests in them."""
    folder = cache_folder()
    return [file.stem.rpartition("-")[0] for file in folder.glob("*.nbc")] if folder else []


def _n_kernels(jobs: Sequence[Job]) -> int:
    """Return about how many kernels have to be compiled: the jobs, and what they call and has no file at all."""
    called = {function for job in jobs for function in functions_of(job.kernel.__wrapped__)}
    called -= {job.kernel.__wrapped__ for job in jobs}
    return len(jobs) + len({f"{kernel.__module__}.{kernel.__qualname__}" for kernel in called} - set(kept_kernels()))


@contextmanager
def _working(jobs: Sequence[Job]) -> Iterator[None]:
    """Let workers compile what they can import, while the body runs; of several processes, one has workers."""
    folder, count = cache_folder(), n_processes() - 1
    with ExitStack() as stack:
        if folder and count and stack.enter_context(lock(folder / "workers", is_ordered=True, waits=False)):
            message = _message(jobs)
            for _ in range(count if message else 0):
                stack.enter_context(_worker(message, folder))
        yield


def _message(jobs: Sequence[Job]) -> bytes:
    """Return the jobs that a worker can import; nothing if one of them cannot be described to another process."""
    try:
        return pickle.dumps([job for job in jobs if job.kernel.__module__.startswith("irsim_gym.")])
    except (pickle.PicklingError, AttributeError, TypeError):
        return b""


@contextmanager
def _worker(message: bytes, folder: Path) -> Iterator[None]:
    command = [sys.executable, "-P", "-m", __name__]
    # What this process imports and where it keeps code may differ from what its environment says.
    path = os.pathsep.join(one or str(Path.cwd()) for one in sys.path)
    environment = {**os.environ, "PYTHONPATH": path, "NUMBA_CACHE_DIR": str(folder.parent)}
    silent = subprocess.DEVNULL
    try:
        process = subprocess.Popen(command, env=environment, stdin=subprocess.PIPE, stdout=silent, stderr=silent)
    except (OSError, ValueError):
        yield
        return
    assert process.stdin is not None
    # A worker reads only after its imports, and a pipe holds little.
    sender = Thread(target=_send, args=(process.stdin, message))
    sender.start()
    try:
        yield
    finally:
        process.kill()
        sender.join()
        with suppress(OSError):
            process.stdin.close()
        process.wait()


def _send(pipe: IO[bytes], message: bytes) -> None:
    with suppress(OSError):
        pipe.write(message)
        pipe.flush()


def n_processes() -> int:
    """Return how many processes compile: as many as there are processors for this one, ``MOST`` at most."""
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    chosen = os.environ.get(SWITCH, "")
    if not sys.executable or hasattr(sys, "frozen"):  # no interpreter could be started
        return 1
    return max(1, int(chosen)) if chosen.isdecimal() else min(usable, MOST)


def main() -> None:
    """Compile the jobs that come as input; nothing is written but files of compiled code."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    compilation().said = True
    jobs: list[Job] = pickle.load(sys.stdin.buffer)
    Thread(target=_end_with_input, daemon=True).start()
    for job in jobs:
        job.compile(waits=False)


def _end_with_input() -> None:
    sys.stdin.buffer.read()
    os._exit(0)


if __name__ == "__main__":
    main()
