"""What runs beside the learning: clock, progress bar, log, checkpoints and an orderly stop."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger, TensorBoardOutputFormat

from irsim_gym.training.checkpoint_files import RunProgress
from irsim_gym.training.run import Run

LOG_ROWS = 200


class StopLearningError(Exception):
    """Leaves the learning between two updates, after the checkpoint was written."""


class StopRequest:
    """Whether a signal asked to stop. The second Ctrl-C stops at once."""

    def __init__(self) -> None:
        self.signal: int | None = None

    @contextmanager
    def listening(self) -> Iterator[StopRequest]:
        """Listen to Ctrl-C and SIGTERM; in a thread other than the main one do nothing."""
        if threading.current_thread() is not threading.main_thread():
            yield self
            return
        kinds = (signal.SIGINT, signal.SIGTERM)
        before = {kind: signal.signal(kind, self._take) for kind in kinds}
        try:
            yield self
        finally:
            for kind, handler in before.items():
                signal.signal(kind, handler)

    def _take(self, number: int, frame: FrameType | None) -> None:
        if self.signal is not None:
            raise KeyboardInterrupt
        self.signal = number


class Clock:
    """Wall-clock and processor time of training alone."""

    def __init__(self, seconds: float, cpu_seconds: float) -> None:
        self._before = (seconds, cpu_seconds)
        self._start: tuple[float, float] | None = None

    def start(self) -> None:
        """Count from now on."""
        self._start = (time.perf_counter(), time.process_time())

    def stop(self) -> None:
        """Count no longer."""
        self._before, self._start = self.read(), None

    def read(self) -> tuple[float, float]:
        """Return wall-clock and processor seconds."""
        if self._start is None:
            return self._before
        wall, cpu = time.perf_counter() - self._start[0], time.process_time() - self._start[1]
        return self._before[0] + wall, self._before[1] + cpu


def tensorboard_logger(run: Run) -> Logger:
    """Return the logger of a run, which writes for TensorBoard."""
    return Logger(str(run.folder), [TensorBoardOutputFormat(str(run.folder / "tensorboard"))])


class TrainingBar:
    """How far a run is, on a terminal.

    Args:
        progress: How far the run has come.
        total: Steps of the whole run.
        console: Where the bar goes; where that is no terminal there is none.
    """

    def __init__(self, progress: RunProgress, total: int, console: Console) -> None:
        self._total, self._console = total, console
        self._begun = (progress.steps, progress.training_seconds)
        self._bar = Progress(
            TextColumn("{task.fields[steps]} steps"),
            BarColumn(),
            TextColumn("{task.fields[speed]} steps/s  success {task.fields[success]}"),
            TimeRemainingColumn(),
            console=console,
            disable=not console.is_terminal,
        )
        self._line = self._bar.add_task(
            "training", total=total, completed=progress.steps, steps="0", speed="-", success="-"
        )

    def start(self) -> None:
        """Show the bar."""
        self._bar.start()

    def stop(self) -> None:
        """Take the bar down; safe to call twice."""
        self._bar.stop()

    def show(self, progress: RunProgress, success: float | None) -> None:
        """Bring the bar up to date.

        Args:
            progress: How far the run is now.
            success: Share of recent episodes that succeeded; None where none ended.
        """
        seconds = progress.training_seconds - self._begun[1]
        speed = (progress.steps - self._begun[0]) / seconds if seconds > 0.0 else 0.0
        self._bar.update(
            self._line,
            completed=progress.steps,
            steps=f"{progress.steps:,}",
            speed=f"{speed:,.0f}",
            success="-" if success is None else f"{success:.0%}",
        )

    def tell(self, progress: RunProgress, success: float | None) -> None:
        """Write a line into a log that shows no bar: how far the run is, and how well recent episodes went."""
        if self._console.is_terminal:
            return
        recent = "" if success is None else f", success {success:.0%} of recent training episodes"
        line = f"{progress.steps:,} of {self._total:,} steps after {progress.training_seconds:,.0f} s{recent}"
        self._console.print(line, markup=False, highlight=False, soft_wrap=True)


class TrainingMonitor(BaseCallback):
    """The callback of a run.

    Args:
        progress: How far the run has come; updated.
        total: Steps of the whole run.
        checkpoint_every: Steps between checkpoints.
        save: Writes a checkpoint.
        stop: Whether to stop.
        console: Where the progress bar goes; where that is no terminal, a line for each checkpoint.
    """

    def __init__(
        self,
        progress: RunProgress,
        total: int,
        checkpoint_every: int,
        save: Callable[[], object],
        stop: StopRequest,
        console: Console,
    ) -> None:
        super().__init__()
        self.progress, self.total, self.save_checkpoint, self.stop = progress, total, save, stop
        self.checkpoint_every = checkpoint_every
        self.next_checkpoint = (progress.steps // checkpoint_every + 1) * checkpoint_every
        self.clock = Clock(progress.training_seconds, progress.cpu_seconds)
        self.bar = TrainingBar(progress, total, console)

    def _on_training_start(self) -> None:
        self.bar.start()
        self.clock.start()

    def _on_rollout_start(self) -> None:
        """Look around between an update and the next rollout: here nothing is half done."""
        self.note()
        if self.stop.signal is not None:
            self._save()
            raise StopLearningError
        if self.progress.steps >= self.next_checkpoint and self.progress.steps < self.total:
            self._save()
            self.next_checkpoint += self.checkpoint_every

    def _on_step(self) -> bool:
        return True

    def note(self) -> None:
        """Bring the progress, its log and the bar up to date."""
        progress, model = self.progress, self.model
        progress.steps = model.num_timesteps
        progress.training_seconds, progress.cpu_seconds = self.clock.read()
        logged = progress.history[-1]["steps"] if progress.history else 0
        if progress.steps - logged < self.total / LOG_ROWS:
            return
        row = {"steps": progress.steps, "training_seconds": progress.training_seconds}
        episodes, successes = model.ep_info_buffer, model.ep_success_buffer
        if episodes:
            row["episode_return"] = sum(float(episode["r"]) for episode in episodes) / len(episodes)
            row["episode_steps"] = sum(float(episode["l"]) for episode in episodes) / len(episodes)
        if successes:
            row["success"] = sum(successes) / len(successes)
        share = getattr(self.training_env.unwrapped, "idle_share", None)
        if share is not None:
            row["idle_share"] = share
        progress.history.append(row)
        self.bar.show(progress, row.get("success"))

    def tell(self) -> None:
        """Write a line into a log that shows no bar, see ``TrainingBar.tell``."""
        successes = self.model.ep_success_buffer
        self.bar.tell(self.progress, sum(successes) / len(successes) if successes else None)

    def finish(self) -> None:
        """Take the clock and the bar down; safe to call twice."""
        self.clock.stop()
        self.bar.stop()

    def _save(self) -> None:
        self.clock.stop()
        self.save_checkpoint()
        self.tell()
        self.clock.start()
