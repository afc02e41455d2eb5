"""Pictures of a world in files: figures, films, pages, sheets."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from irsim_gym.errors import NoEffectWarning
from irsim_gym.live.arguments import figure_options, film_options
from irsim_gym.live.camera import FIGURES, FILMS, target
from irsim_gym.live.driven import ENDING_S, Driven
from irsim_gym.live.painted import PaintedBeams


class Filmed(Driven):
    """Keeps frames, and writes them and others to files."""

    _record: bool
    _save_at_end: bool
    _unsaved: bool
    _film: Mapping[str, Any]

    @property
    def painted(self) -> PaintedBeams:
        """Beams in colours of their own; ``Body.set_laser_color`` paints them."""
        return self._camera.painted

    @property
    def save_ani(self) -> bool:
        """``end`` writes a film."""
        return self._save_at_end

    def close(self, ending_time: float = 0.0, **film: Any) -> None:
        """Close the window and free the renderer; with ``save_ani`` write the film before, as ``end`` does.

        May be called twice; the world can still be used.

        Args:
            ending_time: How long a window stays open before [s].
            **film: As for ``end``.
        """
        self._finish(ending_time, film_options(film))

    def end(self, ending_time: float = ENDING_S, ani_name: str | Path | None = None, **film: Any) -> Path | None:
        """Write the film if frames were kept, and either ``save_ani`` or a name asks for it; then close.

        Where a name is given but no frames were kept, a warning says so.

        Args:
            ending_time: How long a window stays open before [s]; a person may close it sooner.
            ani_name: The film's file, as for ``save_animation``.
            **film: IR-SIM's other arguments: ``suffix=".gif"`` is that of a name without one; ``rm_fig_path`` and
                ``last_frame_duration`` change nothing, others neither, but give a warning. What is not given here is
                taken from ``load(ani_kwargs=...)``.

        Returns:
            The film's path, None when none was written.
        """
        named = {} if ani_name is None else {"ani_name": ani_name}
        return self._finish(ending_time, {**film_options(film), **named})

    def _finish(self, ending_time: float, given: Mapping[str, Any]) -> Path | None:
        options = {**self._film, **given}
        name, film = options.get("ani_name"), None
        if self._unsaved and (self._save_at_end or name is not None):
            film = self.save_animation(_film_name(options, self.name))
        elif "ani_name" in given and not self._record:
            message = "no film was written: load(..., record=True) keeps frames"
            warnings.warn(message, NoEffectWarning, stacklevel=3)
        self._linger(ending_time)
        self._free()
        return film

    def _free(self) -> None:
        self._close_window()
        self._camera.close()

    def quit(self) -> None:
        """Close, and end the program (``SystemExit``)."""
        self._quit = True
        self.end(ending_time=0.0)
        raise SystemExit(0)

    def reset_plot(self) -> None:
        """Do nothing: every picture is drawn anew."""

    def _keep_frame(self) -> None:
        if self._record and self.sampling:
            self._camera.keep(self._shown_status())
            self._unsaved = True

    def save_figure(
        self,
        path: str | Path | None = None,
        include_index: bool = False,
        save_gif: bool = False,
        *,
        save_name: str | Path | None = None,
        **options: Any,
    ) -> Path:
        """Write a picture to a file and return its path.

        Args:
            path: ``.png``, ``.pdf``, ``.svg`` and so on; without a suffix the scenario's
                ``plot.saved_figure.format`` is used, and without a path the world's name.
            include_index: Put the number of the step behind the name.
            save_gif: Keep the moment for the film as well.
            save_name: IR-SIM's name for ``path``.
            **options: Keys of ``plot.saved_figure`` in place of the scenario's, such as ``dpi=300``. Others change
                nothing but give a warning.

        Raises:
            ScenarioError: One of the options has a bad value.
            ValueError: Another suffix.
        """
        file = target(save_name if path is None else path, self.name)
        if include_index:
            suffix = file.suffix if file.suffix.lower() in FIGURES else ""
            file = file.with_name(f"{file.name.removesuffix(suffix)}_{self.count:04d}{suffix}")
        if save_gif:
            self._camera.keep(self._shown_status())
            self._unsaved = True
        return self._camera.save_figure(file, self._shown_status(), figure_options(options))

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


def _film_name(options: Mapping[str, Any], name: str) -> Path:
    """Return the file of a film: what is named, else the world's name, with a suffix where one is given."""
    chosen, suffix = Path(options.get("ani_name") or name), options.get("suffix")
    return chosen.with_name(f"{chosen.name}{suffix}") if suffix and chosen.suffix.lower() not in FILMS else chosen
