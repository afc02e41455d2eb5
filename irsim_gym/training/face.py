"""Hyper-parameters, and summaries of several seeds."""

from irsim_gym.training.hyperparameters import Hyperparameters, Linear, load_hyperparameters
from irsim_gym.training.seed_summary import (
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

__all__ = ["WORST", "Figures", "Hyperparameters", "Linear", "load_hyperparameters", "markdown_table", "named_as_runs"]
__all__ += ["percent", "said_of_seeds", "seed_cells", "summarize_seeds", "write_seeds"]
