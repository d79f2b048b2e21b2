"""How a linear probe is taught."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.checks import need_at_least, need_between, need_positive
from sceneq_core.encoding.probe import Probe

BATCH = 512


@dataclass(frozen=True, slots=True)
class ProbeTrainingParams:
    """Softmax regression by AdamW with a cosine schedule.

    ``rounds`` over all examples, ``step`` the first learning rate, ``decay`` of the weights;
    ``smoothing`` of the right answer and ``dropout`` of the feature keep it from learning few
    things by heart; ``seed`` of the order and the dropout.
    """

    rounds: int = 40
    step: float = 3e-3
    decay: float = 0.1
    smoothing: float = 0.05
    dropout: float = 0.2
    seed: int = 0

    def __post_init__(self) -> None:
        need_at_least(self, 1, "rounds")
        need_positive(self, "step")
        need_at_least(self, 0, "decay", "seed")
        need_between(self, 0, 1, "smoothing", "dropout")


def train_probe(
    features: Float32, names: Sequence[str], params: ProbeTrainingParams | None = None
) -> Probe:
    """Return a probe taught with pooled ``features`` (N, F) and the name of each.

    A name counts by the square root of how often it occurs: chairs are many, and no reason to
    call everything a chair. Same examples, same order: same probe.

    Raises:
        ValueError: not one name for each feature, or fewer than two different names.
    """
    import torch

    params = params or ProbeTrainingParams()
    known = sorted(set(names))
    if len(names) != len(features) or len(known) < 2:
        raise ValueError(f"names: {len(names)} of {len(known)} kinds, {len(features)} features")
    length = np.linalg.norm(features, axis=1, keepdims=True)
    unit = features / np.maximum(length, np.float32(1e-9))
    centre, spread = unit.mean(axis=0), unit.std(axis=0) + np.float32(1e-3)
    place = {name: number for number, name in enumerate(known)}
    with torch.random.fork_rng():
        torch.manual_seed(params.seed)
        weights, bias = _regress(
            torch.from_numpy(np.ascontiguousarray((unit - centre) / spread, np.float32)),
            torch.tensor([place[name] for name in names]),
            params,
        )
    scaled = (weights / spread[:, None]).astype(np.float32)
    return Probe(tuple(known), scaled, (bias - centre @ scaled).astype(np.float32))


def _regress(inputs: Any, targets: Any, params: ProbeTrainingParams) -> tuple[Float32, Float32]:
    """Return weights (F, H) and bias (H,) for tensors of inputs (N, F) and targets (N,)."""
    import torch
    from torch.nn import functional

    count = torch.bincount(targets).float()
    layer = torch.nn.Linear(inputs.shape[1], len(count))
    torch.nn.init.zeros_(layer.weight)
    torch.nn.init.zeros_(layer.bias)
    optimiser = torch.optim.AdamW(layer.parameters(), lr=params.step, weight_decay=params.decay)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, params.rounds)
    importance = count.rsqrt() / count.rsqrt().mean()
    for _ in range(params.rounds):
        order: Any = torch.randperm(len(inputs))
        for rows in order.split(BATCH):
            loss: Any = functional.cross_entropy(
                layer(functional.dropout(inputs[rows], params.dropout)),
                targets[rows],
                weight=importance,
                label_smoothing=params.smoothing,
            )
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
        schedule.step()
    return layer.weight.detach().numpy().T, layer.bias.detach().numpy()
