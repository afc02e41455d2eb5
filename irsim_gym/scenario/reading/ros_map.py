"""Maps of ROS: a YAML file that says how the pixels of an image beside it are read."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats
from irsim_gym.base.errors import OptionError, ScenarioError, UnreadableFileError
from irsim_gym.base.options import kind, option, option_fields
from irsim_gym.base.outside_files import reading
from irsim_gym.scenario.checking.validation import Report, build

SUFFIXES = (".yaml", ".yml")
OCCUPIED = 50.0
"""Occupancy [%] above which a cell is occupied."""


@kind
class RosMapFile:
    """The keys of the file that are read."""

    image: str = option(min_length=1, meaning="File of the image, relative to this file.")
    resolution: float = option(gt=0.0, unit="m", meaning="Side of a pixel.")
    origin: tuple[float, float, float] = option(unit="m, m, rad", meaning="Pose of the lower left corner.")
    occupied_thresh: float = option(ge=0.0, le=1.0, meaning="Pixels with a larger share of black are occupied.")
    free_thresh: float = option(ge=0.0, le=1.0, meaning="Pixels with a smaller share of black are free.")
    negate: int = option(0, ge=0, le=1, meaning="1: white is occupied instead of black.")
    mode: Literal["trinary", "scale", "raw"] = option("trinary", meaning="What lies between the thresholds.")


@dataclass(frozen=True)
class RosMapImage:
    """A map of ROS.

    Attributes:
        content: Its file.
        image: The file of its image.
        size: Numbers of columns and rows.
    """

    content: RosMapFile
    image: Path
    size: tuple[int, int]

    @property
    def extent(self) -> dict[str, float | tuple[float, float]]:
        """Width, height and lower left corner [m] under the keys of the section ``world``."""
        width, height = (round(count * self.content.resolution, 9) for count in self.size)
        return {"width": width, "height": height, "offset": self.content.origin[:2]}

    def occupancy(self) -> Floats:
        """Return the occupancy of each pixel from 0 to 100, NaN where it is unknown, row by row from the top."""
        from PIL import Image

        content = self.content
        with reading(self.image, "image"), Image.open(self.image) as picture:
            gray, opacity = np.moveaxis(np.asarray(picture.convert("LA"), np.float64), -1, 0)
        if content.mode == "raw":
            return np.where(gray <= 100.0, gray, np.nan)
        black = gray / 255.0 if content.negate else (255.0 - gray) / 255.0
        low, high = content.free_thresh, content.occupied_thresh
        between = np.full_like(black, np.nan)
        if content.mode == "scale" and high > low:
            between = np.where(opacity == 255.0, 100.0 * (black - low) / (high - low), np.nan)
        return np.where(black > high, 100.0, np.where(black < low, 0.0, between))

    def occupied(self, unknown: bool) -> Flags:
        """Return which cells are occupied, ``(columns, rows)``, from the left and from the bottom.

        Args:
            unknown: Whether unknown ones are.
        """
        occupied = np.nan_to_num(self.occupancy(), nan=100.0 if unknown else 0.0) > OCCUPIED
        return np.ascontiguousarray(np.fliplr(occupied.T))


def read_ros_map(file: Path) -> RosMapImage:
    """Return a map of ROS; its pixels are read when they are asked for.

    Raises:
        OptionError: The file, or its image, cannot be used; the message names the lines of the file.
    """
    from PIL import Image

    try:
        report = Report.of_file(file)
        values = {key: report.mapping.get(key) for key in option_fields(RosMapFile)}
        negate = values["negate"]
        values["negate"] = int(negate) if isinstance(negate, bool) else negate
        content = build(RosMapFile, values, (), report)
        if content is not None and content.origin[2] != 0.0:
            turn = f"its yaw must be 0, got {content.origin[2]:g}: turn the image instead"
            report.add(("origin",), turn)
        if content is not None and content.free_thresh > content.occupied_thresh:
            report.add(("free_thresh",), f"must not exceed occupied_thresh, {content.occupied_thresh:g}")
        report.check()
        assert content is not None, "build has reported problems"
        image = file.parent / content.image
        with reading(image, "image"), Image.open(image) as picture:
            return RosMapImage(content, image, picture.size)
    except ScenarioError as error:
        told = "; ".join(f"{file}:{problem.line} {problem.path}: {problem.message}" for problem in error.problems)
        raise OptionError("path", f"no map of ROS: {told}") from None
    except UnreadableFileError as error:
        raise OptionError("path", f"{file} cannot be used: {error}") from None
