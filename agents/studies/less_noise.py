"""Copy a policy.zip whose actions have less noise, to train on from it.

    python agents/studies/less_noise.py runs/late/policy.zip 0.2 quiet.zip
    irsim-gym train general_robot --from quiet.zip --seed 1

A policy that learns with much noise may rely on it: with its mean actions it stands still where noise would have led
on. With less noise it meets such places in training. The standard deviations of all actions become DEVIATION; they are
learnt from there on.
"""

from __future__ import annotations

import io
import math
import sys
import zipfile
from pathlib import Path

import torch

WEIGHTS = "policy.pth"


def with_deviation(policy: Path, deviation: float, to: Path) -> None:
    """Write a copy of a policy of Stable-Baselines3 whose actions have a standard deviation."""
    with zipfile.ZipFile(policy) as read, zipfile.ZipFile(to, "w") as written:
        for name in read.namelist():
            content = read.read(name)
            if name == WEIGHTS:
                weights = torch.load(io.BytesIO(content), weights_only=True)
                weights["log_std"].fill_(math.log(deviation))
                stream = io.BytesIO()
                torch.save(weights, stream)
                content = stream.getvalue()
            written.writestr(name, content)


if __name__ == "__main__":
    with_deviation(Path(sys.argv[1]), float(sys.argv[2]), Path(sys.argv[3]))
