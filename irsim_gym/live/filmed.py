"""Pictures of a world in files: figures, films, pages, sheets."""

from __future__ import annotations

from pathlib import Path

from irsim_gym.live.camera import target
from irsim_gym.live.driven import ENDING_S, Driven


class Filmed(Driven):
    """Keeps frames, and writes them and others to files."""

    _record: bool
    _save_at_end: bool
    _unsaved: bool

    def close(self) -> None:
        """Close the window and free the renderer. May be called twice; the world can still be used."""
        self._close_window()
        self._camera.close()

    def end(self, ending_time: float = ENDING_S, ani_name: str | Path | None = None) -> Path | None:
        """Write the film if the world was loaded with ``save_ani`` or a name is given, and close.

        Args:
            ending_time: How long a window stays open before [s]; a person may close it sooner.
            ani_name: The film's file, as for ``save_animation``.

        Returns:
            The film's path, None when none was written.

        Raises:
            ValueError: A film is asked for, but no frames were kept.
        """
        asked = ani_name is not None or (self._save_at_end and self._unsaved)
        film = self.save_animation(ani_name) if asked else None
        self._linger(ending_time)
        self.close()
        return film

    def _keep_frame(self) -> None:
        if self._record and self.sampling:
            self._camera.keep(self._shown_status())
            self._unsaved = True

    def save_figure(self, path: str | Path | None = None) -> Path:
        """Write a picture to a file and return its path.

        Args:
            path: ``.png``, ``.pdf``, ``.svg`` and so on; without a suffix the scenario's
                ``plot.saved_figure.format`` is used, and without a path the world's name. Dots per inch are
                ``plot.saved_figure.dpi`` there, not an argument as in IR-SIM.

        Raises:
            ValueError: Another suffix.
        """
        return self._camera.save_figure(target(path, self.name), self._shown_status())

    def save_animation(self, path: str | Path | None = None, fps: float | None = None) -> Path:
        """Write the frames kept so far to a film, let go of them, and return its path.

        Args:
            path: ``.mp4`` or ``.gif``; without a suffix it becomes an mp4, and without a path the world's name is used.
            fps: Frames per second; by default as fast as the world's own time.

        Raises:
            ValueError: Another suffix, or no frames: a world keeps them when it is loaded with ``record=True``.
        """
        rate = 1.0 / (self.scenario.world.steps_per_sample * self.step_time) if fps is None else fps
        film = self._camera.save_film(target(path, self.name), rate)
        self._unsaved = False
        return film

    def save_html(self, path: str | Path | None = None) -> Path:
        """Write a page that plays all episodes since the world was loaded, in any browser; return its path.

        Args:
            path: ``.html``, also without the suffix; by default the world's name.

        Raises:
            ValueError: Another suffix, or nothing was kept: a world keeps it when it is loaded with ``record=True``.
        """
        return self._camera.save_html(target(path, self.name))

    def save_sheet(self, path: str | Path | None = None, moments: int = 12) -> Path:
        """Write one picture with moments, evenly spaced, of what ``save_animation`` writes or wrote; return its path.

        Args:
            path: ``.png`` or another picture of pixels; by default the world's name with ``-sheet``.
            moments: How many; the first and the last are among them.

        Raises:
            ValueError: Another suffix, nothing was kept, or fewer than two moments.
        """
        return self._camera.save_sheet(target(path, f"{self.name}-sheet"), moments)

    def save_strobe(self, path: str | Path | None = None) -> Path:
        """Write one picture with the ways of the robots in this episode, coloured by time; return its path.

        Args:
            path: ``.png``, ``.pdf``, ``.svg`` and so on; by default the world's name with ``-strobe``.

        Raises:
            ValueError: Another suffix, or nothing was kept.
        """
        return self._camera.save_strobe(target(path, f"{self.name}-strobe"))
