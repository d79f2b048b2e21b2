"""Reports as clients see them: the answer, and what its form adds."""

from collections.abc import Sequence

from sceneq_core.routing.answer import (
    AMBIGUOUS,
    FALLBACK,
    FAST,
    FOUND,
    NOT_FOUND,
    REASONED,
    Match,
)
from sceneq_core.routing.forms import COUNT, WHAT, WHEN
from sceneq_core.routing.report import Report
from sceneq_core.routing.saying import say
from sceneq_core.routing.scene import SceneInstance
from sceneq_core.routing.tally import Tally
from sceneq_core.routing.whereabouts import Whereabouts
from sceneq_nodes._answer_json import Json, Stamp, answer_json

STAMPED = ("cost", "map", "calibration", "query_id", "took_ms")
"""What belongs to the whole answer and not to each of its targets."""

ROUTES = (FALLBACK, REASONED, FAST)
"""Several targets took the first of these that one of them took."""


def report_json(report: Report, k: int, stamp: Stamp) -> Json:
    """Return a report; everything that is counted is listed, else the best ``k``."""
    now_ns = report.answer.revision.stamp_ns
    shown = max(k, len(report.tally.matches)) if report.tally and report.kind == COUNT else k
    body = answer_json(report.answer, shown, stamp)
    head = {name: body.pop(name) for name in ("status", "question")}
    return {**head, "form": report.kind, "said": say(report, now_ns), **_facts(report, k), **body}


def _facts(report: Report, k: int) -> Json:
    """Return what the form adds to a ranking."""
    facts: Json = {}
    now_ns, best = report.answer.revision.stamp_ns, report.best
    if report.exists:
        facts["exists"] = report.exists
    if report.tally is not None and report.kind in (COUNT, WHAT):
        facts["count"] = _count_json(report.tally)
    found = report.answer.status != NOT_FOUND
    if report.where is not None and found and report.kind not in (COUNT, WHAT):
        facts["where"] = _where_json(report.where)
    if report.kind == WHEN and found:
        facts["last_seen"] = [_seen_json(one, now_ns) for one in report.answer.matches[:k]]
    if report.missing:
        facts["missing"] = report.missing
    if report.gone is not None:
        facts["gone"] = _seen_json(report.gone, now_ns)
    if not found and best is not None:
        where = {"where": report.where.said()} if report.where else {}
        facts["nearest_miss"] = {**_thing_json(best.instance), "p": round(best.p, 4), **where}
    return facts


def reports_json(reports: Sequence[Report], text: str, k: int, stamp: Stamp) -> Json:
    """Return several reports as one: the best of each, and each with its own ranking."""
    targets = [report_json(report, k, stamp) for report in reports]
    statuses = {target["status"] for target in targets}
    status = FOUND if statuses == {FOUND} else AMBIGUOUS
    best = [one["instances"][0] for one in targets if one["instances"]]
    unsure = min(targets, key=lambda one: float(one["confidence"]["p_max"]))
    return {
        "status": NOT_FOUND if statuses == {NOT_FOUND} else status,
        "question": text,
        "form": reports[0].kind,
        "said": " ".join(one["said"] for one in targets),
        "targets": [{n: v for n, v in one.items() if n not in STAMPED} for one in targets],
        "instances": best,
        "confidence": unsure["confidence"],
        "route": next((r for r in ROUTES if any(one["route"] == r for one in targets)), FAST),
        "cached": all(one["cached"] for one in targets),
        "reason": "; ".join(f"{one['question']}: {one['reason']}" for one in targets),
        "cost": _costs(targets),
        **{name: value for name, value in unsure.items() if name in STAMPED and name != "cost"},
    }


def _costs(targets: Sequence[Json]) -> Json:
    costs = [target["cost"] for target in targets]
    return {
        **costs[-1],
        "vlm_calls": sum(cost["vlm_calls"] for cost in costs),
        "tokens": {way: sum(cost["tokens"][way] for cost in costs) for way in ("in", "out")},
        "money": round(sum(cost["money"] for cost in costs), 6),
    }


def _count_json(tally: Tally) -> Json:
    return {
        "sure": len(tally.sure),
        "possible": len(tally.possible),
        "expected": round(tally.expected, 2),
        "sure_ids": [one.instance.instance_id for one in tally.sure],
        "possible_ids": [one.instance.instance_id for one in tally.possible],
    }


def _where_json(where: Whereabouts) -> Json:
    body: Json = {"said": where.said()}
    if where.support is not None:
        body[where.relation] = _thing_json(where.support)
    if where.landmark is not None:
        near = {**_thing_json(where.landmark), "distance_m": round(where.distance_m, 3)}
        body["near"] = near
    return body


def _seen_json(match: Match, now_ns: int) -> Json:
    one = match.instance.geometry
    return {
        **_thing_json(match.instance),
        "p": round(match.p, 4),
        "state": one.state,
        "last_seen_ns": one.last_seen_ns,
        "age_s": round((now_ns - one.last_seen_ns) / 1e9, 3),
        "centre": [round(float(x), 3) for x in one.centre_world],
    }


def _thing_json(instance: SceneInstance) -> Json:
    return {"id": instance.instance_id, "label": instance.label.name}
