"""The tables of a report, from its document; the same rows for a terminal and for a page."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

from sceneq_core.evaluation.protocol import PROTOCOLS
from sceneq_tools.evaluation.retrieval import ALL, BucketScore
from sceneq_tools.evaluation.retrieval_queries import BUCKETS
from sceneq_tools.evaluation.suite_scene import RIGHT, ROUTES, WRONG

Json = Mapping[str, Any]
Row = tuple[str, ...]

MEASURES = ("ap", "ap50", "ap25")
SPLITS200 = ("head", "common", "tail")
CALIBRATION_NOTES = ("protocol", "routing_protocol", "as_routed_protocol")
WHERE = ("recordings", "setting")
ASKED = (*WHERE, "candidates", "hit")
ABSENT = "-"
HITS = (("true instances", "true mask"), ("map", "IoU >= 0.5"), ("map", "IoU >= 0.25"))


@dataclass(frozen=True, slots=True)
class Table:
    """Rows under ``columns``, of which the first ``texts`` are words and the others numbers."""

    columns: Row
    rows: tuple[Row, ...]
    title: str = ""
    texts: int = 1


def summary(document: Json) -> Table:
    """Return one row for each split: what to look at first."""
    columns = (
        *("recordings", "number", "instances: agnostic AP50", "own-labels AP50"),
        *(f"Hit@1 {candidates}, {rule}" for candidates, rule in HITS),
    )
    rows = []
    for split, instances in document["instances"].items():
        of = {one["protocol"]: one for one in instances["protocols"]}
        number = sum(one["split"] == split for one in document["recordings"])
        shown = (ap(of["agnostic"]["ap50"]), ap(of["own-labels"]["ap50"]))
        rows.append((split, str(number), *shown, *_first_hits(document["retrieval"], split)))
    return Table(columns, tuple(rows), "what to look at first; the graph as it is")


def _first_hits(records: Sequence[Json], split: str) -> Iterator[str]:
    """Yield Hit@1 over all questions for each of ``HITS``, in the first setting."""
    first = {
        (one["candidates"], one["hit_rule"]): one
        for one in reversed(records)
        if one["split"] == split
    }
    return (hit(first[kind], ALL) if kind in first else ABSENT for kind in HITS)


def recordings(records: Iterable[Json]) -> Table:
    """Return what was evaluated."""
    columns = (
        *("recording", "use", "truth and questions", "map", "frames", "keyframes"),
        *("true instances", "never seen", "in the map", "questions", "lost or refused"),
    )
    rows = tuple(
        (
            *(one["name"], one["split"], one["sha256"][:12]),
            one["map"]["key"] + (" (was there)" if one["map"]["was_there"] else ""),
            *(str(one[name]) for name in ("frames", "keyframes", "things", "unseen_things")),
            *(str(one["map"]["instances"]), str(one["questions"])),
            ", ".join(f"{name} {n}" for name, n in one["map"]["troubles"].items()) or "none",
        )
        for one in records
    )
    return Table(columns, rows, texts=4)


def makers(records: Iterable[Json]) -> Iterator[str]:
    """Yield one line for every generator and library that recordings were made by."""
    of_maker: dict[str, list[str]] = {}
    for one in records:
        if one["made_by"]:
            of_maker.setdefault(one["made_by"], []).append(one["name"])
    for made_by, names in of_maker.items():
        yield f"made by {made_by}: {', '.join(names)}"


def instances_by_split(by_split: Mapping[str, Json]) -> Table:
    """Return AP of all protocols, the recordings of a split together."""
    columns = (
        *("recordings", "protocol", "AP", "AP50", "AP25"),
        *(f"{name} AP" for name in SPLITS200),
        *("objects", "predictions", "smallest region, points"),
    )
    rows = tuple(
        (
            *(split, one["protocol"]),
            *(ap(one[measure]) for measure in MEASURES),
            *(_split_ap(one, name) for name in SPLITS200),
            *(str(one["objects"]), str(one["predictions"]), str(one["min_region"])),
        )
        for split, report in by_split.items()
        for one in report["protocols"]
    )
    return Table(columns, rows, "recordings of one kind together", texts=2)


def _split_ap(result: Json, name: str) -> str:
    """Return AP of a group of classes; where classes do not count there are no groups."""
    labelled = PROTOCOLS[result["protocol"]].labels_match
    return ap(result["splits"][name]["ap"]) if labelled else ABSENT


def instances_by_recording(records: Iterable[Json]) -> Table:
    """Return AP and AP50 of every recording in all protocols."""
    records = list(records)
    protocols = records[0]["instances"]["protocols"] if records else ()
    columns = tuple(f"{one['protocol']} {m}" for one in protocols for m in ("AP", "AP50", "AP25"))
    rows = tuple(
        (one["name"], *(ap(p[m]) for p in one["instances"]["protocols"] for m in MEASURES))
        for one in records
    )
    return Table(("recording", *columns), rows, "every recording alone")


def protocol_rules(by_split: Mapping[str, Json]) -> Iterator[str]:
    """Yield one line for every protocol, and what is void in ScanNet200."""
    reports = list(by_split.values())
    for one in reports[0]["protocols"] if reports else ():
        overlaps = f"IoU {one['overlaps'][0]:.2f}:0.05:{one['overlaps'][-2]:.2f}"
        yield f"{one['protocol']}: {one['rules']}; {overlaps}"
    outside = sorted({label for report in reports for label in report["outside_scannet200"]})
    if outside:
        yield f"not in ScanNet200, void in scannet200: {', '.join(outside)}"


def retrieval(records: Sequence[Json]) -> Table:
    """Return Hit@1 by bucket for every kind of candidates, setting and split."""
    columns = (
        *ASKED,
        *(f"{name} @1" for name in BUCKETS),
        *("all @1", "all @5", "no candidate", "fast", "reasoned", "ms", "VLM calls"),
    )
    return Table(columns, tuple(map(_retrieval_row, records)), "Hit@1 by bucket", texts=4)


def _retrieval_row(record: Json) -> Row:
    total = bucket(record, ALL)
    asked = total["questions"]
    return (
        *_asked(record),
        *(hit(record, name) for name in BUCKETS),
        hit(record, ALL),
        hit(record, ALL, "hit_5"),
        str(total["unreachable"]),
        share(total["fast"], asked),
        share(total["reasoned"], asked),
        f"{total['ms']:.1f}",
        str(total["vlm_calls"]),
    )


def retrieval_by_recording(records: Iterable[Json]) -> Table:
    """Return Hit@1 over all questions of every recording."""
    records = list(records)
    kinds = [(o["candidates"], o["hit_rule"]) for o in records[0]["retrieval"]] if records else []
    columns = ("recording", "questions", *(f"{name}, {rule}" for name, rule in kinds))
    rows = tuple(
        (one["name"], str(one["questions"]), *(hit(o, ALL) for o in one["retrieval"]))
        for one in records
    )
    return Table(columns, rows, "Hit@1 over all questions, every recording alone")


def routes(records: Iterable[Json]) -> Table:
    """Return the confusion of the routes: who decided, and was it right."""
    columns = (
        *ASKED,
        *(f"{route} {how}" for route in ROUTES for how in (RIGHT, WRONG)),
        *("claims", "claims right", "not found", "wrongly so"),
    )
    rows = tuple(
        (
            *_asked(one),
            *(str(one["routes"][route][how]) for route in ROUTES for how in (RIGHT, WRONG)),
            *(str(bucket(one, ALL)[name]) for name in ("found", "found_right", "not_found")),
            str(one["wrongly_not_found"]),
        )
        for one in records
    )
    return Table(columns, rows, texts=4)


def fitted_says(fitted: Json) -> str:
    """Say what was fitted on what."""
    gate = ", ".join(f"{name} {value:g}" for name, value in fitted["gate"].items())
    return (
        f"configured = as the graph says; fitted = on {', '.join(fitted['recordings'])} "
        f"(T by NLL of {fitted['temperature_fitted_on']}, thresholds by F1): "
        f"T {fitted['temperature']:g}, {gate}."
    )


def calibration(record: Json) -> Table:
    """Return the measures of every task in one setting."""
    columns = (
        *("guesses", "n", "right", "mean p", "NLL", "Brier", "top Brier", "ECE width"),
        *("ECE mass", "by chance", "as much", "beyond", "90 %"),
        *("AURC", "least AURC", "AUROC p", "margin", "entropy"),
    )
    rows = tuple(_task_row(task) for task in record["tasks"])
    title = f"{record['split']}, {record['setting']}: T {record['temperature']:g}"
    return Table(columns, rows, title)


def _task_row(task: Json) -> Row:
    numbers = ("confidence", "nll", "brier", "top_brier", "ece_width", "ece_mass", "ece_noise")
    return (
        *(task_name(task), str(task["guesses"]), f"{100 * task['accuracy']:.0f} %"),
        *(ap(task[name]) for name in (*numbers, "ece_as_much", "ece_beyond")),
        "{:.3f} to {:.3f}".format(*task["ece_interval"]),
        *(ap(task[name]) for name in ("aurc", "least_aurc")),
        *(ap(task["auroc"][name]) for name in ("p_max", "margin", "entropy")),
    )


def task_name(task: Json) -> str:
    """Return what is guessed of what: ``labels -> scannet200``."""
    return f"{task['task'].partition(':')[0]} -> {task['choices']}"


def sensitivity(routing: Json) -> Table:
    """Return F1 of the routing, and what it becomes when one threshold is scaled."""
    factors = list(dict.fromkeys(one["factor"] for one in routing["sensitivity"]))
    names = dict.fromkeys(one["threshold"] for one in routing["sensitivity"])
    rows = []
    for name in names:
        scores = [o["score"] for o in routing["sensitivity"] if o["threshold"] == name]
        rows.append((f"{name} {routing['gate'][name]:g}", *(f"{s['f1']:.3f}" for s in scores)))
    title = (
        f"routing F1 {_decided(routing['f1'])} of {routing['decisions']} questions; as routed "
        f"{_decided(routing['as_routed'])} of {routing['questions']}; with one threshold scaled:"
    )
    return Table(("threshold", *(f"x {factor:g}" for factor in factors)), tuple(rows), title)


def _decided(score: Json) -> str:
    return (
        f"{score['f1']:.3f} (precision {score['precision']:.3f}, recall {score['recall']:.3f}), "
        f"fast path for {100 * score['accepted']:.0f} %"
    )


def ablation(records: Iterable[Json]) -> Table:
    """Return Hit@1 without, with selective and with constant reasoning."""
    columns = (
        *(*WHERE, "reasoning"),
        *(f"{name} @1" for name in (*BUCKETS, ALL)),
        *("reasoned", "ms", "VLM calls"),
    )
    rows = tuple(_ablation_row(one, result) for one in records for result in one["results"])
    return Table(columns, rows, texts=3)


def _ablation_row(record: Json, result: Json) -> Row:
    total = bucket(result, ALL)
    return (
        *(record["split"], record["setting"], result["reasoning"]),
        *(hit(result, name) for name in (*BUCKETS, ALL)),
        share(total["reasoned"], total["questions"]),
        f"{total['ms']:.1f}",
        str(total["vlm_calls"]),
    )


def bucket(record: Json, name: str) -> Json:
    """Return the counts of one bucket; all 0 where nothing was asked in it."""
    empty: Json = dict.fromkeys((field.name for field in fields(BucketScore)), 0)
    return next((one for one in record["buckets"] if one["bucket"] == name), empty)


def hit(record: Json, name: str, what: str = "hit_1") -> str:
    """Return ``67 % of 12``."""
    counts = bucket(record, name)
    asked = counts["questions"]
    return f"{share(counts[what], asked)} of {asked}" if asked else ABSENT


def share(part: int, of: int) -> str:
    """Return ``67 %``."""
    return f"{100 * part / of:.0f} %" if of else ABSENT


def ap(value: float | None) -> str:
    """Return three digits; nothing was there to measure = a dash."""
    return ABSENT if value is None else f"{value:.3f}"


def _asked(record: Json) -> Row:
    return (record["split"], record["setting"], record["candidates"], record["hit_rule"])
