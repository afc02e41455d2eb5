"""Files with pictures of a world: figures, films, pages."""

from collections.abc import Mapping
from pathlib import Path
from typing import NoReturn

from irsim_gym.base.errors import NoEffectWarning, warn_caller
from irsim_gym.live.pictures.camera import Camera
from irsim_gym.live.pictures.output_files import FIGURES, FILMS, PAGES, film_file, target, with_suffix
from irsim_gym.live.pictures.viewer import Viewer
from irsim_gym.live.session.arguments import figure_options, film_options
from irsim_gym.live.session.run_status import RunStatus
from irsim_gym.live.session.session import Session

ENDING_S = 3.0


class MediaWriter:
    """Keeps frames, and writes files.

    Args:
        session: Bodies of the world.
        status: Status that pictures show.
        camera: Draws them.
        viewer: The window, which ``end`` closes.
        record: Whether to keep frames.
        save_at_end: Whether ``end`` writes a film.
        options: Defaults of ``end``.
    """

    def __init__(
        self,
        session: Session,
        status: RunStatus,
        camera: Camera,
        viewer: Viewer,
        *,
        record: bool,
        save_at_end: bool,
        options: Mapping[str, object],
    ) -> None:
        self._session, self._status, self._camera, self._viewer = session, status, camera, viewer
        self._record, self._save_at_end, self._options = record or save_at_end, save_at_end, options
        self._unsaved = False

    @property
    def save_ani(self) -> bool:
        """Whether ``end`` writes a film."""
        return self._save_at_end

    def note_moment(self) -> None:
        """Keep a frame if frames are kept and the present moment is a sample."""
        if self._record and self._camera.is_sample:
            self._keep()

    def _keep(self) -> None:
        self._camera.keep(self._status.shown)
        self._unsaved = True

    def _file(self, path: str | Path | None) -> Path:
        return target(path, self._session.simulation.scenario.name)

    def close(self, /, ending_time: float = 0.0, **film: object) -> None:
        """Close the window and free the renderer. With ``save_ani``, write the film first, as ``end`` does.

        It may be called twice, and the world can still be used.

        Args:
            ending_time: Time for which a window stays open before [s].
            **film: As for ``end``.
        """
        self._finish(ending_time, film_options(film))

    def end(self, /, ending_time: float = ENDING_S, ani_name: str | Path | None = None, **film: object) -> Path | None:
        """Write the film if ``save_ani`` or ``ani_name`` asks for it, then close.

        If a name is given but no frames were kept, it warns.

        Args:
            ending_time: Time for which a window stays open before [s]. Closing the window ends it sooner.
            ani_name: File of the film, as for ``save_animation``.
            **film: IR-SIM's other arguments: ``suffix=".gif"`` is that of a name without one; ``rm_fig_path`` and
                ``last_frame_duration`` change nothing, others neither, but give a warning. What is not given here is
                taken from ``load(ani_kwargs=...)``.

        Returns:
            The film's path, None when none was written.
        """
        named = {} if ani_name is None else {"ani_name": ani_name}
        return self._finish(ending_time, {**film_options(film), **named})

    def _finish(self, ending_time: float, ending: Mapping[str, object]) -> Path | None:
        options = {**self._options, **ending}
        name, film = options.get("ani_name"), None
        if self._unsaved and (self._save_at_end or name is not None):
            film = self.save_animation(film_file(options, self._session.simulation.scenario.name))
        elif "ani_name" in ending and not self._record:
            warn_caller("no film was written: load(..., record=True) keeps frames", NoEffectWarning)
        self._viewer.wait(ending_time)
        self.free()
        return film

    def free(self) -> None:
        """Close the window and free the renderer."""
        self._viewer.close()
        self._camera.close()

    def quit(self) -> NoReturn:
        """Close everything, and end the program (``SystemExit``)."""
        self._viewer.quit = True
        self.end(ending_time=0.0)
        raise SystemExit(0)

    def save_figure(
        self,
        /,
        path: str | Path | None = None,
        include_index: bool = False,
        save_gif: bool = False,
        *,
        save_name: str | Path | None = None,
        **options: object,
    ) -> Path:
        """Write a picture to a file and return its path.

        Args:
            path: ``.png``, ``.pdf``, ``.svg`` and so on. Without a suffix, that of the scenario's
                ``plot.saved_figure.format`` is used; without a path, the name of the world.
            include_index: Whether to append the number of the step to the name.
            save_gif: Whether to keep the moment for the film, too.
            save_name: IR-SIM's name for ``path``.
            **options: Keys of ``plot.saved_figure`` in place of the scenario's, such as ``dpi=300``. Others change
                nothing but give a warning.

        Raises:
            ScenarioError: One of the options has a bad value.
            ValueError: Another suffix.
        """
        file = self._file(save_name if path is None else path)
        if include_index:
            suffix = file.suffix if file.suffix.lower() in FIGURES else ""
            file = file.with_name(
                f"{file.name.removesuffix(suffix)}_{int(self._session.simulation.state.step[0]):04d}{suffix}"
            )
        if save_gif:
            self._keep()
        return self._camera.save_figure(file, self._status.shown, figure_options(options))

    def save_animation(self, path: str | Path | None = None, fps: float | None = None) -> Path:
        """Write the frames kept so far to a film, remove them, and return its path.

        Args:
            path: ``.mp4`` or ``.gif``. Without a suffix, it becomes an mp4; without a path, the name of the world is
                used.
            fps: Frames per second (default: the film plays in real time).

        Raises:
            ValueError: Another suffix, or no frames: a world keeps them when it is loaded with ``record=True``.
        """
        world = self._session.simulation.scenario.world
        rate = 1.0 / (world.steps_per_sample * world.step_time) if fps is None else fps
        film = with_suffix(self._file(path), FILMS, "mp4")
        self._camera.reel.save_film(film, rate)
        self._unsaved = False
        return film

    def save_html(self, path: str | Path | None = None) -> Path:
        """Write a page that plays all episodes since the world was loaded, and return its path.

        It opens in any browser.

        Args:
            path: ``.html``, with or without the suffix (default: name of the world).

        Raises:
            ValueError: Another suffix, or nothing was kept: a world keeps it when it is loaded with ``record=True``.
        """
        page = with_suffix(self._file(path), PAGES, "html")
        self._camera.reel.save_html(page)
        return page
