"""What the scene graph of the map already knows about two things."""

from sceneq_core.reasoning.reasoner import Candidate

_ELSEWHERE = 0.5
"""What is left of a box's word when the map has seen the thing rest on something else."""


def with_known(relation: str, target: Candidate, anchor: Candidate, by_boxes: float) -> float:
    """Return how well a relation holds, 0 to 1, from the map's contacts and the boxes' opinion.

    The map has looked at the surfaces where they touch; boxes only bound them.
    """
    if relation == "on" and target.supported_by:
        rests = target.supported_by == anchor.instance_id
        return 1.0 if rests else _ELSEWHERE * by_boxes
    if relation == "in" and target.inside == anchor.instance_id:
        return 1.0
    if relation in ("under", "supports") and anchor.supported_by == target.instance_id:
        return 1.0
    if relation == "contains" and anchor.inside == target.instance_id:
        return 1.0
    if relation == "next_to" and target.supported_by == anchor.instance_id:
        return _ELSEWHERE * by_boxes
    return by_boxes
