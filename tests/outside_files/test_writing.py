"""Faults while files are written: a full disk, two processes in one folder, links that lead out of it."""

from __future__ import annotations

import io
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import run as command
from irsim_gym.training.runs.checkpoint import write_checkpoint

from irsim_gym.base.outside_files import remove
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.protocol.tables import write_bytes
from irsim_gym.evaluation.saved_policies.checkpoint_files import RunProgress
from irsim_gym.rendering.films.video import write_video
from irsim_gym.rendering.looks.files import whole_file
from irsim_gym.training.settings.folders import sole_writer

SMALL = 4096
FRAMES = [np.random.default_rng(k).integers(0, 255, (240, 320, 3), np.uint8) for k in range(6)]


@pytest.fixture
def small_files() -> Iterator[None]:
    """No file can be larger than some bytes: the error is another than that of a full disk, and as nameless."""
    resource = pytest.importorskip("resource")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (SMALL, hard))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


class Model:
    """As much of a model as a checkpoint needs."""

    def save(self, room: io.BytesIO) -> None:
        room.write(bytes(10 * SMALL))

    def get_vec_normalize_env(self) -> None:
        return None


@pytest.mark.usefixtures("small_files")
def test_what_has_no_room_is_named_and_leaves_nothing(tmp_path: Path) -> None:
    def page(path: Path) -> None:
        with whole_file(path) as part:
            part.write_bytes(bytes(10 * SMALL))

    model: Any = Model()
    writers = {
        "rows.csv": lambda path: write_bytes(path, bytes(10 * SMALL)),
        "page.html": page,
        "film.mp4": lambda path: write_video(FRAMES, path, 10.0),
        "film.gif": lambda path: write_video(FRAMES, path, 10.0),
        "0000000007": lambda path: write_checkpoint(path.parent, model, RunProgress(7), {}),
    }
    for name, write in writers.items():
        with pytest.raises(OSError, match=r"large|ffmpeg could not write the film") as told:
            write(tmp_path / name)
        assert told.value.filename == str(tmp_path / name)
        assert list(tmp_path.iterdir()) == [], name


def test_a_command_without_room_ends_with_one_sentence(
    small_files: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert command(monkeypatch, "draw", "empty_goal", "--out", "x.png") == 1
    assert capsys.readouterr().err.strip() == "cannot use x.png: File too large"
    assert list(tmp_path.iterdir()) == []


def test_one_process_trains_into_a_folder(tmp_path: Path) -> None:
    """A second one is refused, and the lock ends with its process, however that ends."""
    folder = tmp_path / "run"
    code = (
        f"from irsim_gym.base.compiled.lock import sole; "
        f"import time\nwith sole({str(tmp_path / '.run.lock')!r}) as free:\n"
    )
    other = subprocess.Popen([sys.executable, "-c", f"{code} print(free, flush=True); time.sleep(60)"], stdout=-1)
    assert other.stdout is not None
    assert other.stdout.readline() == b"True\n"
    with pytest.raises(IrsimGymError, match=r"another process trains into .*run"), sole_writer(folder):
        pass
    other.kill()
    other.wait()
    other.stdout.close()
    assert (tmp_path / ".run.lock").exists()
    with sole_writer(folder), pytest.raises(IrsimGymError, match="--out"), sole_writer(folder):
        pass
    assert list(tmp_path.iterdir()) == []


def test_of_a_link_the_link_goes(tmp_path: Path) -> None:
    inside = tmp_path / "a" / "b"
    inside.mkdir(parents=True)
    (tmp_path / "link").symlink_to(tmp_path / "a")
    remove(tmp_path / "link")
    remove(tmp_path / "gone")
    assert inside.is_dir()
    remove(tmp_path / "a")
    assert list(tmp_path.iterdir()) == []
