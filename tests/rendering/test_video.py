"""Films can be read back, are whole or absent, and hold their panels."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.rendering.films.film import EpisodeFilm, caption_strip, grid
from irsim_gym.rendering.films.video import VideoWriter, write_video


def pictures(count: int, height: int = 48, width: int = 64) -> list[Bytes]:
    frames = []
    for k in range(count):
        frame = np.full((height, width, 3), 255, np.uint8)
        frame[:, : 4 + 4 * k % width] = (0, 158, 115)
        frames.append(frame)
    return frames


def read_mp4(path: Path) -> tuple[list[Bytes], str]:
    """Return the frames, and what ffmpeg says about the file's video stream."""
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    result = subprocess.run(command, capture_output=True, check=True)
    about = next(line for line in result.stderr.decode().splitlines() if "Video:" in line)
    found = re.search(r", (\d+)x(\d+)", about)
    assert found is not None
    width, height = int(found[1]), int(found[2])
    return list(np.frombuffer(result.stdout, np.uint8).reshape(-1, height, width, 3)), about


def read_gif(path: Path) -> tuple[list[Bytes], list[int]]:
    with Image.open(path) as image:
        frames, durations = [], []
        for k in range(image.n_frames):
            image.seek(k)
            frames.append(np.asarray(image.convert("RGB")))
            durations.append(image.info["duration"])
        assert image.info["loop"] == 0
    return frames, durations


def test_mp4_is_read_back(tmp_path: Path) -> None:
    path = tmp_path / "films" / "a.mp4"
    written = pictures(9)
    write_video(iter(written), path, fps=10)
    frames, about = read_mp4(path)
    assert len(frames) == 9
    assert all(words in about for words in ("h264", "yuv420p", "10 fps"))
    assert frames[0].shape == (48, 64, 3)
    assert np.abs(frames[4].astype(int) - written[4])[:, 40:].max() < 16
    assert [entry.name for entry in path.parent.iterdir()] == ["a.mp4"]


def test_mp4_starts_with_its_index(tmp_path: Path) -> None:
    write_video(pictures(3), tmp_path / "a.mp4", fps=10)
    data = (tmp_path / "a.mp4").read_bytes()
    assert data.index(b"moov") < data.index(b"mdat")


def test_gif_is_read_back(tmp_path: Path) -> None:
    path = tmp_path / "a.gif"
    written = pictures(9)
    write_video(written, path, fps=10)
    frames, durations = read_gif(path)
    assert len(frames) == 9
    assert durations == [100] * 9
    for mine, theirs in zip(written, frames, strict=True):
        assert np.abs(mine.astype(int) - theirs).max() <= 8


@pytest.mark.parametrize(("fps", "total"), [(30, 1000), (60, 500), (144, 208)])
def test_gif_keeps_time_at_any_rate(tmp_path: Path, fps: int, total: int) -> None:
    write_video(pictures(30), tmp_path / "a.gif", fps)
    _, durations = read_gif(tmp_path / "a.gif")
    assert min(durations) >= 20
    assert sum(durations) == pytest.approx(total, abs=20)


def test_gif_takes_a_new_palette_for_new_colours(tmp_path: Path) -> None:
    frames = pictures(4)
    frames.append(np.full_like(frames[0], (220, 38, 38)))
    write_video(frames, tmp_path / "a.gif", 10)
    assert np.abs(read_gif(tmp_path / "a.gif")[0][-1].astype(int) - (220, 38, 38)).max() <= 4


def test_a_thin_line_of_a_new_colour_is_seen_in_a_gif(tmp_path: Path) -> None:
    """It covers less than a hundredth of the picture; the first frame's colours are grey."""
    grey = np.repeat((np.arange(200) % 256).astype(np.uint8)[None, :, None], 200, axis=0).repeat(3, axis=2)
    marked = grey.copy()
    marked[100:102, 20:180] = (220, 38, 38)
    write_video([grey, marked], tmp_path / "a.gif", 10)
    shown = read_gif(tmp_path / "a.gif")[0][-1].astype(int)
    assert np.abs(shown[100:102, 20:180] - (220, 38, 38)).max() <= 8


def test_several_files_at_once(tmp_path: Path) -> None:
    paths = [tmp_path / "a.mp4", tmp_path / "a.gif"]
    write_video(iter(pictures(5)), paths, fps=5)
    assert len(read_mp4(paths[0])[0]) == len(read_gif(paths[1])[0]) == 5


def test_odd_sizes_are_made_even(tmp_path: Path) -> None:
    write_video(pictures(2, 33, 45), tmp_path / "a.mp4", fps=10)
    assert read_mp4(tmp_path / "a.mp4")[0][0].shape == (34, 46, 3)


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_a_broken_film_leaves_the_old_one(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    path.write_text("the old film")

    def frames() -> Iterator[Bytes]:
        yield from pictures(3)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_video(frames(), path, fps=10)
    assert path.read_text() == "the old film"
    assert list(tmp_path.iterdir()) == [path]


def test_bad_calls(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no frames"):
        write_video([], tmp_path / "a.mp4", fps=10)
    with pytest.raises(ValueError, match=r"ends in \.mp4 or \.gif"):
        VideoWriter(tmp_path / "a.avi", fps=10)
    for fps in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="frame rate"):
            VideoWriter(tmp_path / "a.mp4", fps=fps)
    with pytest.raises(ValueError, match="one shape"):
        write_video([*pictures(1), *pictures(1, 50)], tmp_path / "a.mp4", fps=10)
    with pytest.raises(ValueError, match="a frame is uint8"):
        write_video([np.zeros((4, 4, 4), np.uint8)], tmp_path / "a.gif", fps=10)
    assert list(tmp_path.iterdir()) == []


def test_the_writer_used_by_hand(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "a.mp4", 10) as writer:
        for frame in pictures(4):
            writer.append(frame)
    assert len(read_mp4(tmp_path / "a.mp4")[0]) == 4


def test_panels_wait_for_each_other() -> None:
    film = EpisodeFilm(["one", "two"], fps=10, hold=0.5)
    short, long = pictures(3), pictures(7)
    frames = list(film.frames([iter(short), iter(long)]))
    assert len(frames) == 7 + 5
    strip = caption_strip("one", 64).shape[0]
    assert frames[0].shape == (48 + strip, 128, 3)
    for k, frame in enumerate(frames):
        assert np.array_equal(frame[strip:, :64], short[min(k, 2)])
        assert np.array_equal(frame[strip:, 64:], long[min(k, 6)])
    assert not np.shares_memory(frames[-1], frames[-2])


def test_captions_are_written() -> None:
    strip = caption_strip("PPO", 600)
    assert strip.dtype == np.uint8
    assert strip.shape[1] == 600
    assert strip.shape[0] % 2 == 0
    assert strip.min() < 80 < 200 < strip.max()
    assert not np.array_equal(strip, caption_strip("SAC", 600))
    assert next(iter(EpisodeFilm([""], 10).frames([pictures(1)]))).shape == (48, 64, 3)


@pytest.mark.parametrize(
    ("count", "rows", "columns"), [(1, 1, 1), (2, 1, 2), (3, 1, 3), (4, 2, 2), (5, 2, 3), (8, 2, 4), (9, 3, 3)]
)
def test_grids_are_even(count: int, rows: int, columns: int) -> None:
    frames = [np.full((10, 20, 3), k, np.uint8) for k in range(count)]
    picture = grid(frames)
    assert picture.shape == (10 * rows, 20 * columns, 3)
    assert all((picture[10 * (k // columns), 20 * (k % columns)] == k).all() for k in range(count))


def test_levels_follow_each_other(tmp_path: Path) -> None:
    film = EpisodeFilm(["one", "two"], fps=10, hold=0.2)
    levels = ([pictures(count), pictures(2)] for count in (3, 5))
    film.write(levels, tmp_path / "a.mp4")
    assert len(read_mp4(tmp_path / "a.mp4")[0]) == 3 + 2 + 5 + 2


def test_wrong_numbers_of_episodes() -> None:
    film = EpisodeFilm(["one", "two"], fps=10)
    with pytest.raises(ValueError, match="2 captions for 1 episodes"):
        list(film.frames([pictures(1)]))
    with pytest.raises(ValueError, match="at least one frame"):
        list(film.frames([pictures(1), []]))
