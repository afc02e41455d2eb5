"""Writes films: mp4 and gif files that appear only when complete."""

import errno
import os
import subprocess
from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import imageio_ffmpeg
import numpy as np
from PIL import Image
from rich.console import Console
from rich.progress import Progress

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.outside_files import writing

# Constant quality without visible loss; with the index at the front, browsers can start before the download ends. For
# flat colours, the preset "medium" takes twice the time for a file of the same size.
CODEC = (
    *("-vcodec", "libx264", "-pix_fmt", "yuv420p", "-crf", "18", "-preset", "veryfast"),
    *("-movflags", "+faststart", "-loglevel", "error"),
)
# Browsers slow down gifs with shorter frames [hundredths of a second].
SHORTEST_GIF_FRAME = 2
GIF_COLOURS = 256
# A palette is replaced if more than a share of the pixels is off by more than a number of levels: many pixels are
# slightly off, or the colour of a thin line is missing.
LARGEST_SHARES_OFF = ((0.02, 4), (1e-4, 48))


class VideoWriter:
    """Writes frames to a film, one after another; use it in a ``with`` statement.

    The film is written to a temporary file and renamed at the end, so that ``path`` never holds an incomplete film.
    After an exception, the temporary file is removed.

    Args:
        path: File to write, ``.mp4`` (H.264, yuv420p) or ``.gif``. Missing folders are created.
        fps: Frames per second.

    Raises:
        ValueError: If the suffix is not supported, or the frame rate is not positive.
    """

    def __init__(self, path: str | Path, fps: float) -> None:
        self.path = Path(path)
        if self.path.suffix.lower() not in _ENCODERS:
            raise ValueError(f"a film's name ends in {' or '.join(_ENCODERS)}, got {self.path.name!r}")
        if not 0.0 < fps < float("inf"):
            raise ValueError(f"the frame rate must be a positive number, got {fps}")
        self._fps = float(fps)
        self._shape: tuple[int, ...] | None = None
        self._part = self.path.with_name(f".{self.path.stem}.{os.getpid()}.part{self.path.suffix.lower()}")
        self._encoder: _Mp4 | _Gif | None = None

    def append(self, frame: Bytes) -> None:
        """Add a frame.

        Args:
            frame: uint8, shape ``(height, width, 3)``, the same for all frames.

        Raises:
            ValueError: If the frame is not a picture, or its shape differs from that of the first frame.
        """
        if self._encoder is None:
            if frame.dtype != np.uint8 or frame.ndim != 3 or frame.shape[2] != 3:
                raise ValueError(f"a frame is uint8 (height, width, 3), got {frame.dtype} {frame.shape}")
            self._shape = frame.shape
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._encoder = _ENCODERS[self.path.suffix.lower()](self._part, self._fps)
        if frame.shape != self._shape:
            raise ValueError(f"all frames of a film have one shape: {self._shape}, got {frame.shape}")
        with writing(self.path):
            self._encoder.append(_even(frame))

    def close(self) -> None:
        """Finish the film.

        Raises:
            ValueError: If the video has no frames.
        """
        if self._encoder is None:
            raise ValueError(f"no frames for {self.path}")
        with writing(self.path):
            self._encoder.finish()
        self._encoder = None
        self._part.replace(self.path)

    def discard(self) -> None:
        """Discard the film and remove its temporary file."""
        if self._encoder is not None:
            self._encoder.abandon()
            self._encoder = None
        self._part.unlink(missing_ok=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                self.close()
        finally:
            self.discard()


def write_video(
    frames: Iterable[Bytes], path: str | Path | Sequence[str | Path], fps: float, *, total: int | None = None
) -> None:
    """Write frames to one film, or to several (mp4 and gif) at once.

    Args:
        frames: Frames, uint8, shape ``(height, width, 3)``; they are consumed one by one and not kept.
        path: File or files to write, ``.mp4`` or ``.gif``.
        fps: Frames per second.
        total: Number of frames, for a progress bar on the terminal; None for no bar.

    Raises:
        ValueError: If there are no frames, their shapes differ, the suffix is not supported, or the frame rate is not
            positive.
    """
    paths = [path] if isinstance(path, str | Path) else list(path)
    writers = [VideoWriter(each, fps) for each in paths]
    screen = Console(stderr=True)
    quiet = total is None or not screen.is_terminal
    try:
        with Progress(console=screen, disable=quiet, transient=True) as bar:
            for frame in bar.track(frames, total, description="filming"):
                for writer in writers:
                    writer.append(frame)
            for writer in writers:
                writer.close()
    finally:
        for writer in writers:
            writer.discard()


def _even(frame: Bytes) -> Bytes:
    """Repeat the last row and column if their number is odd, since H.264 with yuv420p requires even sizes."""
    height, width = frame.shape[:2]
    if height % 2 == 0 and width % 2 == 0:
        return frame
    return np.pad(frame, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")


class _Mp4:
    """H.264 in a widely supported profile, encoded by ffmpeg; a film that it could not finish is an error."""

    def __init__(self, path: Path, fps: float) -> None:
        self._path, self._rate = path, str(Fraction(fps).limit_denominator())
        self._process: subprocess.Popen[bytes] | None = None

    def append(self, frame: Bytes) -> None:
        if self._process is None:
            height, width = frame.shape[:2]
            given = ["-f", "rawvideo", "-vcodec", "rawvideo", "-s", f"{width}x{height}", "-pix_fmt", "rgb24"]
            command = [_ffmpeg(), "-y", *given, "-r", self._rate, "-i", "-", "-an", *CODEC, str(self._path)]
            pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stderr": subprocess.PIPE, "start_new_session": True}
            self._process = subprocess.Popen(command, **pipes)
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(np.ascontiguousarray(frame).data)
        except OSError:
            self.finish()
            raise

    def finish(self) -> None:
        assert self._process is not None
        process, self._process = self._process, None
        told = process.communicate()[1].decode(errors="replace").strip()
        if process.returncode:
            reason = told.splitlines()[0].rpartition("] ")[2] if told else f"status {process.returncode}"
            raise OSError(errno.EIO, f"ffmpeg could not write the film: {reason}")

    def abandon(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.communicate()
            self._process = None


def _ffmpeg() -> str:
    """Return the program that encodes films.

    Raises:
        IrsimGymError: There is none.
    """
    try:
        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except RuntimeError as error:
        raise IrsimGymError(f"no ffmpeg for .mp4 ({str(error).splitlines()[0]}): write a .gif") from None


class _Gif:
    """A looping gif without dithering, which flat colours do not need.

    A palette is reused as long as it fits, because frames with the same palette compress to half the size. Frames last
    whole hundredths of a second, so durations are rounded cumulatively.
    """

    def __init__(self, path: Path, fps: float) -> None:
        self._path, self._fps = path, fps
        self._images: list[Image.Image] = []
        self._shown_from: list[int] = []
        self._count = 0
        self._palette: Image.Image | None = None

    def append(self, frame: Bytes) -> None:
        begin = round(100 * self._count / self._fps)
        self._count += 1
        if not self._shown_from or begin - self._shown_from[-1] >= SHORTEST_GIF_FRAME:
            self._images.append(self._reduced(frame))
            self._shown_from.append(begin)

    def _reduced(self, frame: Bytes) -> Image.Image:
        """Reduce the colours with the last palette, or with a new one if the difference would be visible."""
        picture = Image.fromarray(frame)
        if self._palette is not None:
            reduced = picture.quantize(palette=self._palette, dither=Image.Dither.NONE)
            if _is_faithful(reduced, frame):
                return reduced
        self._palette = picture.quantize(GIF_COLOURS, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
        return self._palette

    def finish(self) -> None:
        end = max(round(100 * self._count / self._fps), self._shown_from[-1] + SHORTEST_GIF_FRAME)
        durations = [10 * (after - begin) for begin, after in pairwise([*self._shown_from, end])]
        first, *others = self._images
        # Pillow's optimization takes half of the time, saves a fifth of the file, and gives some frames an alpha
        # channel that many readers reject.
        how: dict[str, Any] = {"loop": 0, "disposal": 1, "optimize": False}
        first.save(self._path, save_all=True, append_images=others, duration=durations, **how)
        self._images = []

    def abandon(self) -> None:
        self._images = []


def _is_faithful(reduced: Image.Image, frame: Bytes) -> bool:
    """Return whether colours have hardly changed, in every second pixel of every second row."""
    colours = np.array(reduced.getpalette(), np.int16).reshape(-1, 3)
    shown = colours[np.asarray(reduced)[::2, ::2]]
    off = np.abs(shown - frame[::2, ::2]).max(axis=2)
    return all(float((off > levels).mean()) <= share for share, levels in LARGEST_SHARES_OFF)


_ENCODERS: dict[str, type[_Mp4 | _Gif]] = {".mp4": _Mp4, ".gif": _Gif}
