"""Hyper-parameters, and summaries of several seeds."""

from irsim_gym.training.curves.seed_summary import (
    WORST,
    Figures,
    markdown_table,
    named_as_runs,
    percent,
    said_of_seeds,
    seed_cells,
    summarize_seeds,
    write_seeds,
)
from irsim_gym.training.settings.hyperparameters import Hyperparameters, Linear, load_hyperparameters

__all__ = ["WORST", "Figures", "Hyperparameters", "Linear", "load_hyperparameters", "markdown_table", "named_as_runs"]
__all__ += ["percent", "said_of_seeds", "seed_cells", "summarize_seeds", "write_seeds"]
