"""Pictures that notebooks display."""

import base64
import io
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Bytes

RGB = 3


class NotebookPicture(np.ndarray[Any, Any]):
    """An array that Jupyter and IPython display as a picture.

    Otherwise it is a NumPy array. Slices are displayed as pictures if they are uint8 ``(height, width, 3)``, else as
    numbers. Results of computations are plain arrays.
    """

    __array_priority__: ClassVar[float] = -1.0

    def __array_wrap__(self, array: NDArray[Any], context: object = None, return_scalar: bool = False) -> Any:
        plain = np.asarray(array)
        return plain[()] if return_scalar or plain.ndim == 0 else plain

    def _repr_png_(self) -> bytes | None:
        return png(self) if is_picture(self) else None


class PictureList(list[Bytes]):
    """Successive pictures, which Jupyter and IPython display as a film.

    Args:
        pictures: uint8, shape ``(height, width, 3)`` each.
        fps: Pictures per second.
    """

    def __init__(self, pictures: Iterable[Bytes] = (), fps: float = 10.0) -> None:
        super().__init__(pictures)
        self.fps = fps

    def _repr_html_(self) -> str | None:
        """Return the film as self-contained HTML, H.264 with the last picture as poster; None without pictures."""
        if not self or not all(is_picture(picture) and picture.shape == self[0].shape for picture in self):
            return None
        from irsim_gym.rendering.films.video import write_video

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "film.mp4"
            write_video((np.asarray(picture) for picture in self), path, self.fps)
            film = path.read_bytes()
        height, width = self[0].shape[:2]
        return (
            f'<video controls loop muted playsinline width="{width}" height="{height}" style="max-width: 100%; '
            f'height: auto" poster="data:image/png;base64,{_base64(png(self[-1]))}" '
            f'src="data:video/mp4;base64,{_base64(film)}"></video>'
        )


def is_picture(array: NDArray[Any]) -> bool:
    """Return whether an array is uint8, of shape ``(height, width, 3)``, and not empty."""
    return array.dtype == np.uint8 and array.ndim == RGB and array.shape[2] == RGB and array.size > 0


def png(picture: Bytes) -> bytes:
    """Return a picture ``(height, width, 3)`` as the content of a PNG file."""
    from PIL import Image

    content = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(picture)).save(content, "png", compress_level=4)
    return content.getvalue()


def _base64(content: bytes) -> str:
    return base64.b64encode(content).decode("ascii")
