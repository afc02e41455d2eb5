"""Writes films: mp4 and gif files that appear only when complete."""

import errno
import os
import subprocess
from collections.abc import Iterable, Sequence
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Self

import imageio_ffmpeg
import numpy as np
from rich.console import Console
from rich.progress import Progress

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.outside_files import writing

# Constant quality without visible loss; with the index at the front, browsers can start before the download ends. For
# flat colours, the preset "medium" takes twice the time for a file of the same size.
MP4 = ["-vcodec", "libx264", "-pix_fmt", "yuv420p", "-crf", "18", "-preset", "veryfast", "-movflags", "+faststart"]
# Browsers slow down gifs with frames shorter than 0.02 s. All frames share a palette, which makes small files; ffmpeg
# holds them in memory until the last one, with 4 bytes a pixel. Flat colours need no dithering.
PALETTE = "fps=min(source_fps\\,50),split[a][b];[a]palettegen[p];[b][p]paletteuse=dither=none"
ENCODINGS = {".mp4": MP4, ".gif": ["-filter_complex", PALETTE, "-loop", "0"]}


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
        if self.path.suffix.lower() not in ENCODINGS:
            raise ValueError(f"a film's name ends in {' or '.join(ENCODINGS)}, got {self.path.name!r}")
        if not 0.0 < fps < float("inf"):
            raise ValueError(f"the frame rate must be a positive number, got {fps}")
        self._rate = str(Fraction(float(fps)).limit_denominator())
        self._shape: tuple[int, ...] | None = None
        self._part = self.path.with_name(f".{self.path.stem}.{os.getpid()}.part{self.path.suffix.lower()}")
        self._encoder: subprocess.Popen[bytes] | None = None

    def append(self, frame: Bytes) -> None:
        """Add a frame.

        Args:
            frame: uint8, shape ``(height, width, 3)``, the same for all frames.

        Raises:
            ValueError: If the frame is not a picture, or its shape differs from that of the first frame.
        """
        if self._shape is None:
            if frame.dtype != np.uint8 or frame.ndim != 3 or frame.shape[2] != 3:
                raise ValueError(f"a frame is uint8 (height, width, 3), got {frame.dtype} {frame.shape}")
            self._shape = frame.shape
            self.path.parent.mkdir(parents=True, exist_ok=True)
        if frame.shape != self._shape:
            raise ValueError(f"all frames of a film have one shape: {self._shape}, got {frame.shape}")
        even = _even(frame)
        with writing(self.path):
            self._encoder = self._encoder or self._started(*even.shape[:2])
            assert self._encoder.stdin is not None
            try:
                self._encoder.stdin.write(np.ascontiguousarray(even).data)
            except OSError:
                self._finish()
                raise

    def close(self) -> None:
        """Finish the film.

        Raises:
            ValueError: If the video has no frames.
        """
        if self._encoder is None:
            raise ValueError(f"no frames for {self.path}")
        with writing(self.path):
            self._finish()
        self._part.replace(self.path)

    def discard(self) -> None:
        """Discard the film and remove its temporary file."""
        if self._encoder is not None:
            self._encoder.kill()
            self._encoder.communicate()
            self._encoder = None
        self._part.unlink(missing_ok=True)

    def _started(self, height: int, width: int) -> subprocess.Popen[bytes]:
        """Start ffmpeg.

        Raises:
            IrsimGymError: There is none.
        """
        try:
            program = str(imageio_ffmpeg.get_ffmpeg_exe())
        except RuntimeError as error:
            raise IrsimGymError(f"no ffmpeg to write films ({str(error).splitlines()[0]})") from None
        frames = ["-f", "rawvideo", "-s", f"{width}x{height}", "-pix_fmt", "rgb24", "-r", self._rate, "-i", "-"]
        command = [program, "-y", "-loglevel", "error", *frames, *ENCODINGS[self._part.suffix], str(self._part)]
        return subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)

    def _finish(self) -> None:
        """Wait for ffmpeg; a film that it could not finish is an error."""
        assert self._encoder is not None
        encoder, self._encoder = self._encoder, None
        told = encoder.communicate()[1].decode(errors="replace").strip()
        if encoder.returncode:
            reason = told.splitlines()[0].rpartition("] ")[2] if told else f"status {encoder.returncode}"
            raise OSError(errno.EIO, f"ffmpeg could not write the film: {reason}")

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
