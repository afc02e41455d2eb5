"""Keys of hyper-parameter files: our own, those of the algorithms, and those of their networks.

The tables define which values are valid. Which of the keys an algorithm takes follows from its signature.
"""

from typing import Any, Literal

from irsim_gym.base.options import kind, option

ACTIVATIONS = {"relu": "ReLU", "tanh": "Tanh", "elu": "ELU", "silu": "SiLU", "gelu": "GELU", "leaky_relu": "LeakyReLU"}
"""Names of activation functions, and their classes in ``torch.nn``."""
SCHEDULES = ("learning_rate", "clip_range", "clip_range_vf")
"""Keys that also take ``lin_<number>``."""
AUTOMATIC = ("ent_coef", "target_entropy")
"""Keys that also take ``auto``, if the algorithm adjusts them itself."""
GIVEN_ELSEWHERE = {
    "env": "is made from the scenario",
    "seed": "is given by --seed",
    "tensorboard_log": "is the folder tensorboard/ of the run",
    "_init_setup_model": "is for Python",
}
"""Arguments of algorithms that a file must not set, and the reason."""
NOT_IN_FILES = "is a class, which a file cannot hold"
"""Reason for arguments whose values are Python objects."""


@kind
class RunKeys:
    """Our own keys."""

    n_timesteps: int = option(ge=1, unit="steps", meaning="Steps of the whole run, over all worlds and robots.")
    n_envs: int = option(ge=1, le=1_000_000, meaning="Worlds in the batch.")
    until: float | None = option(None, gt=0.0, le=100.0, unit="%", meaning="Success on dev levels that ends the run.")
    team: Literal["episode", "respawn"] | None = option(
        None, meaning="All robots learn; one that has ended waits for its world (episode) or restarts (respawn)."
    )
    mirror: bool = option(False, meaning="ppo exchanges left and right in half of the rows that it learns from.")
    clone: str | None = option(None, min_length=1, meaning="Policy that is imitated first, e.g. pursuit:known=seen.")
    clone_levels: int = option(2000, ge=1, meaning="Number of ``train`` levels that the imitated policy plays.")
    clone_epochs: int = option(8, ge=1, meaning="Number of passes over its successful episodes.")
    torch_threads: int = option(1, ge=1, le=1024, meaning="Number of threads of PyTorch.")
    checkpoint_every: int = option(100_000, ge=1, unit="steps", meaning="Steps between checkpoints.")
    reward_scale: float = option(1.0, gt=0.0, meaning="Factor on the rewards that the algorithm gets.")
    normalize: Any = option(None, meaning="Arguments of VecNormalize; true for its defaults, false for none.")
    # Stable-Baselines3 takes a GPU wherever there is one, even for two small layers; runs there are not repeatable.
    device: str = option("cpu", min_length=1, meaning="Device of the networks: auto, cpu, cuda, cuda:1 or mps.")


@kind
class AlgorithmKeys:
    """Arguments of the algorithms of Stable-Baselines3 and sb3-contrib."""

    policy: str = option(min_length=1, meaning="Name of the policy's class, e.g. MlpPolicy.")
    learning_rate: float = option(gt=0.0, meaning="Learning rate of the optimiser.")
    n_steps: int = option(ge=1, meaning="Steps of each world in a rollout, or of an n-step return.")
    batch_size: int = option(ge=1, meaning="Size of a minibatch.")
    n_epochs: int = option(ge=1, meaning="Number of passes over a rollout.")
    gamma: float = option(ge=0.0, le=1.0, meaning="Discount factor.")
    gae_lambda: float = option(ge=0.0, le=1.0, meaning="Trade-off between bias and variance of the advantages (GAE).")
    clip_range: float = option(gt=0.0, meaning="Clipping range of the policy's ratio.")
    clip_range_vf: float | None = option(gt=0.0, meaning="Clipping range of the value function.")
    normalize_advantage: bool = option(meaning="Normalise the advantages of a minibatch.")
    ent_coef: float = option(ge=0.0, meaning="Weight of the entropy in the loss.")
    vf_coef: float = option(ge=0.0, meaning="Weight of the value loss.")
    max_grad_norm: float = option(gt=0.0, meaning="Maximum norm of the gradient.")
    target_kl: float | None = option(gt=0.0, meaning="Stop an update at this KL divergence.")
    use_sde: bool = option(meaning="Use state-dependent exploration (gSDE).")
    sde_sample_freq: int = option(ge=-1, meaning="Steps between new draws of the gSDE noise; -1: once per rollout.")
    use_sde_at_warmup: bool = option(meaning="Use gSDE before learning starts.")
    rms_prop_eps: float = option(gt=0.0, meaning="Epsilon of RMSProp.")
    use_rms_prop: bool = option(meaning="Use RMSProp instead of Adam.")
    buffer_size: int = option(ge=1, meaning="Number of transitions in the replay buffer.")
    learning_starts: int = option(ge=0, unit="steps", meaning="Number of steps before learning starts.")
    tau: float = option(gt=0.0, le=1.0, meaning="Coefficient of the soft update of the target networks.")
    train_freq: Any = option(meaning="Steps of all worlds between updates, or [1, episode] with one world.")
    gradient_steps: int = option(ge=-1, meaning="Number of updates each time; -1: one per transition.")
    action_noise: float | None = option(ge=0.0, meaning="Standard deviation of noise on actions in [-1, 1].")
    optimize_memory_usage: bool = option(meaning="Store each observation once.")
    target_update_interval: int = option(ge=1, meaning="Steps between updates of the targets.")
    target_entropy: float = option(meaning="Target entropy of ent_coef: auto.")
    exploration_fraction: float = option(gt=0.0, le=1.0, meaning="Share of the run in which exploration decreases.")
    exploration_initial_eps: float = option(ge=0.0, le=1.0, meaning="Share of random actions at the start.")
    exploration_final_eps: float = option(ge=0.0, le=1.0, meaning="Share of random actions at the end.")
    policy_delay: int = option(ge=1, meaning="Updates of the critics per update of the actor.")
    target_policy_noise: float = option(ge=0.0, meaning="Standard deviation of the noise on target actions.")
    target_noise_clip: float = option(ge=0.0, meaning="Bound of the noise on target actions.")
    top_quantiles_to_drop_per_net: int = option(ge=0, meaning="Number of top quantiles to drop per network.")
    stats_window_size: int = option(ge=1, meaning="Number of episodes in logged means.")
    verbose: int = option(ge=0, le=2, meaning="Verbosity of the algorithm.")


@kind
class PolicyKeys:
    """Arguments of the policies: the section ``policy_kwargs``."""

    ortho_init: bool = option(meaning="Initialise weights orthogonally.")
    use_sde: bool = option(meaning="Use state-dependent exploration (gSDE).")
    log_std_init: float = option(meaning="Initial logarithm of the actions' standard deviation.")
    full_std: bool = option(meaning="Use a standard deviation per feature with gSDE.")
    use_expln: bool = option(meaning="Use expln instead of exp for standard deviations.")
    squash_output: bool = option(meaning="Squash actions by tanh.")
    share_features_extractor: bool = option(meaning="Actor and critic share the extractor.")
    normalize_images: bool = option(meaning="Divide images by 255.")
    clip_mean: float = option(ge=0.0, meaning="Limit of the mean action with use_sde.")
    n_critics: int = option(ge=1, meaning="Number of critics.")
    n_quantiles: int = option(ge=1, meaning="Number of quantiles per critic.")
    memory_size: int = option(ge=1, meaning="Length of the memory of gru_ppo.")
