"""What the routing node can be told in the graph."""

from dataclasses import dataclass, field
from typing import Any

from sceneq_core.checks import need_within
from sceneq_core.routing.budget import Budget
from sceneq_core.routing.labels import LabelSet, custom, named
from sceneq_core.routing.policy import PolicyParams
from sceneq_core.routing.remembered import RememberedParams
from sceneq_core.routing.router import RouterParams
from sceneq_core.teaching.book import BookParams


@dataclass(frozen=True, slots=True)
class RoutingParams:
    """``encoder`` must be that of the encoding node: only its texts compare with its images.

    ``labels`` replaces the named ``label_set``. ``calibration``: path of what ``sceneq calibrate``
    wrote, "" = the shipped one of the encoder, "none" = none; its temperature, thresholds and
    "none of them" replace those of encoder, gate and router. ``reason_timeout_s``: how long a
    question waits for the reasoner before it is answered without.

    ``policy``: which questions are worth the reasoner. ``budget``: what the scene may spend on it
    in an hour. ``remembered``: when a verdict still holds.

    ``names``: how taught names stick. ``likeness``: path of what ``sceneq calibrate-names`` wrote,
    which says who inherits them; default: what comes with the program.

    ``meanwhile``: the encoder to answer with until ``encoder`` describes the share ``cover`` of the
    instances that the former can answer with; after that it has no effect.
    """

    encoder: dict[str, Any] = field(default_factory=lambda: {"kind": "conse"})
    label_set: str = "scannet200"
    labels: tuple[str, ...] = ()
    router: RouterParams = field(default_factory=RouterParams)
    calibration: str = ""
    reason_timeout_s: float = 10.0
    policy: PolicyParams = field(default_factory=PolicyParams)
    budget: Budget = field(default_factory=Budget)
    remembered: RememberedParams = field(default_factory=RememberedParams)
    names: BookParams = field(default_factory=BookParams)
    likeness: str = ""
    meanwhile: dict[str, Any] | None = None
    cover: float = 0.95

    def __post_init__(self) -> None:
        need_within(self, 0, 1, "cover")
        if not 0 < self.reason_timeout_s <= 600:
            raise ValueError(f"reason_timeout_s: {self.reason_timeout_s} is not in (0, 600]")

    def chosen_labels(self) -> LabelSet:
        """Return the set of ``labels``, or the named one."""
        return custom(self.labels) if self.labels else named(self.label_set)
