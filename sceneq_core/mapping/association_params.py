"""When superpoints belong together."""

from dataclasses import dataclass

from sceneq_core.checks import need_at_least, need_between, need_positive, need_within


@dataclass(frozen=True, slots=True)
class AssociationParams:
    """When superpoints belong together; agreements are those of ``expected_agreement``.

    Attributes:
        views: keyframes of evidence that are kept per superpoint.
        top_views: keyframes, the most visible ones, by which two groups are compared.
        min_pixels: surface points from which a group is seen in a keyframe, and founded.
        min_score: how well a superpoint has to fit a group to join it.
        hold: how much better than the present group another one has to fit.
        vote_weight: of the share of views in which a group owns the superpoint's segment, against
            the share in which that segment dominates the group; their mean says how well it fits.
        tau_detach: agreement with their group below which superpoints leave it.
        tau_merge: agreement above which two groups are one.
        min_common_views: keyframes that have to show both before two groups merge.
        contact_views: views that it is worth to a superpoint out of view where its surface goes on
            into a group.
        kinship_views: views that it is worth to groups how much they look like one thing: to two
            that are out of view, and to a part that wants to leave its group.
        max_rounds: of refinement in one keyframe; what is left waits for the next one.
    """

    views: int = 16
    top_views: int = 64
    min_pixels: int = 10
    min_score: float = 0.5
    hold: float = 0.05
    vote_weight: float = 0.5
    tau_detach: float = 0.45
    tau_merge: float = 0.5
    min_common_views: int = 2
    contact_views: float = 1.0
    kinship_views: float = 3.0
    max_rounds: int = 2

    def __post_init__(self) -> None:
        need_at_least(self, 1, "views", "top_views", "min_pixels", "min_common_views")
        need_at_least(self, 1, "max_rounds")
        need_between(self, 0, 1, "min_score", "tau_detach", "tau_merge")
        need_within(self, 0, 1, "vote_weight")
        need_positive(self, "hold")
        need_at_least(self, 0, "contact_views", "kinship_views")
        if not self.tau_detach < self.tau_merge:
            raise ValueError(f"tau_detach: must be below tau_merge, got {self.tau_detach}")
