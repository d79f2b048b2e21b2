"""The report as one page of HTML that needs nothing from elsewhere."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape
from typing import Any

from sceneq_tools.evaluation import report_tables as tables
from sceneq_tools.evaluation.charts import bars, reliability, risk_coverage
from sceneq_tools.evaluation.report_tables import Table
from sceneq_tools.evaluation.suite_evaluation import CONFIGURED, stage_times

Json = Mapping[str, Any]

STYLE = """
:root { color-scheme: light; }
body { font: 14px/1.45 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; color: #26282c;
  max-width: 1320px; margin: 32px auto 80px; padding: 0 24px; background: #fff; }
h1 { font-size: 26px; margin: 0 0 6px; } h2 { font-size: 20px; margin: 44px 0 8px; }
h3 { font-size: 15px; margin: 22px 0 6px; } p { margin: 6px 0; max-width: 90ch; }
.note { color: #686c72; font-size: 13px; } code { font: 13px ui-monospace, "DejaVu Sans Mono",
  monospace; background: #f3f4f6; padding: 1px 4px; overflow-wrap: anywhere; }
.wide { overflow-x: auto; } table { border-collapse: collapse; margin: 6px 0 10px; }
th, td { padding: 3px 11px 3px 0; text-align: right; font-variant-numeric: tabular-nums;
  white-space: nowrap; vertical-align: top; }
th { font-weight: 600; border-bottom: 1px solid #999; vertical-align: bottom;
  white-space: normal; max-width: 126px; line-height: 1.25; }
td { border-bottom: 1px solid #eceef0; } th.text, td.text { text-align: left; }
.row { display: flex; flex-wrap: wrap; gap: 20px; } svg { font: 12px system-ui, "DejaVu Sans",
  sans-serif; display: block; } figure { margin: 0; } figcaption { font-size: 13px; color: #686c72;
  max-width: 270px; } .failure { border-top: 1px solid #e3e5e8; padding: 12px 0; }
.failure img, .maps img { display: block; max-width: 100%; } .wrong { color: #b8352a; }
.right { color: #2f7a3c; } .maps { display: grid; gap: 18px;
  grid-template-columns: repeat(auto-fill, minmax(480px, 1fr)); }
"""


def page(document: Json, sheets: Mapping[str, str]) -> str:
    """Return the page of a report; ``sheets`` are data URIs of pictures of the maps, by name."""
    title = f"Scene-Q: {len(document['recordings'])} recordings, {document['date'][:10]}"
    sections = (
        _head(document, title),
        _section("Recordings", _recordings(document)),
        _section("Instances", _instances(document)),
        _section("Retrieval", _retrieval(document)),
        _section("Routes", _routes(document)),
        _section("Calibration", _calibration(document)),
        _section("What reasoning is worth", _ablation(document)),
        _section("Time", _time(document)),
        _section("Worst failures", _failures(document)),
        _section("Maps", _maps(sheets)),
    )
    body = "\n".join(sections)
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}'
        f"</title><style>{STYLE}</style></head><body>\n{body}\n</body></html>\n"
    )


def _head(document: Json, title: str) -> str:
    setup = ", ".join(
        f"{key.replace('_', ' ')} {value}" for key, value in document["setup"].items()
    )
    machine = document["machine"]
    return (
        f"<h1>{escape(title)}</h1><p><code>{escape(document['command'])}</code></p>"
        f'<p class="note">{escape(document["date"])}, sceneq {escape(document["sceneq"])}, '
        f"{machine['cores']} cores ({escape(machine['processor'])}), "
        f"{document['took_s'] / 60:.1f} minutes, of them {document['mapping_s'] / 60:.1f} for maps "
        f"that were not there yet.<br>{escape(setup)}; segmenter {escape(document['segmenter'])}."
        "</p>" + _table(tables.summary(document))
    )


def _recordings(document: Json) -> Iterator[str]:
    yield _table(tables.recordings(document["recordings"]))
    yield _notes(tables.makers(document["recordings"]))


def _instances(document: Json) -> Iterator[str]:
    yield _note(
        "AP of the map's instances against the truth. The protocols count different things: their "
        "numbers must not be compared with each other."
    )
    yield _table(tables.instances_by_split(document["instances"]))
    yield _table(tables.instances_by_recording(document["recordings"]))
    yield _notes(tables.protocol_rules(document["instances"]))


def _retrieval(document: Json) -> Iterator[str]:
    yield _table(tables.retrieval(document["retrieval"]))
    yield _note(
        f"{document['retrieval'][0]['protocol']}; ms: median, the question read for the first time."
    )
    yield _table(tables.retrieval_by_recording(document["recordings"]))


def _routes(document: Json) -> Iterator[str]:
    yield _note(
        "Who decided, and was it right? fast = the encoder alone; reasoned = the reasoner chose; "
        "fallback = it should have, but did not."
    )
    yield _table(tables.routes(document["retrieval"]))


def _calibration(document: Json) -> Iterator[str]:
    if document["fitted"]:
        yield f"<p>{escape(tables.fitted_says(document['fitted']))}</p>"
    for record in document["calibration"]:
        yield _table(tables.calibration(record))
        yield f'<div class="row">{"".join(_diagrams(record))}</div>'
        yield _table(tables.sensitivity(record["routing"]))
    first = document["calibration"][0] if document["calibration"] else {}
    yield _notes(first[key] for key in tables.CALIBRATION_NOTES if first)


def _diagrams(record: Json) -> Iterator[str]:
    for task in record["tasks"]:
        says = f"{tables.task_name(task)}: {task['guesses']} guesses, ECE {task['ece_width']:.3f}"
        yield _figure(reliability(task["bins"]), says)
    curves = {tables.task_name(task): (task["coverage"], task["risk"]) for task in record["tasks"]}
    yield _figure(risk_coverage(curves), "risk against coverage: lower is better")


def _ablation(document: Json) -> Iterator[str]:
    yield _note("The same questions about the true instances, with three ways to reason.")
    yield _table(tables.ablation(document["ablation"]))


def _time(document: Json) -> Iterator[str]:
    recordings = document["recordings"]
    keyframes = sum(one["keyframes"] for one in recordings)
    yield _note(
        f"Of making the maps: mean over {keyframes} keyframes, with what else this machine did. "
        "A stage within another (mapping: ...) is part of it; views and encoding also work between "
        "keyframes. Ratios against this machine's own speed: sceneq bench stages."
    )
    yield bars(stage_times(recordings), "ms a keyframe")


def _failures(document: Json) -> Iterator[str]:
    yield _note(
        "Claims before hesitations, the surest first; questions that no candidate could have "
        "answered are left out. Red: what was answered; green: what is right. "
        f"Setting: {CONFIGURED}."
    )
    yield from map(_failure, document["failures"])


def _failure(record: Json) -> str:
    right = ", ".join(record["right"]) or "there is none"
    answered = record["answered"] or "there is none"
    figures = "".join(
        f'<figure><img src="{picture["image"]}" alt="{escape(picture["says"])}">'
        f'<figcaption class="{_class_of(picture["says"])}">{escape(picture["says"])}</figcaption>'
        "</figure>"
        for picture in record["pictures"]
    )
    return (
        f'<div class="failure"><p><b>{escape(record["question"])}</b> ({escape(record["bucket"])}) '
        f"in {escape(record['recording'])}, {escape(record['candidates'])} "
        f'({escape(record["hit_rule"])})<br><span class="wrong">{escape(record["status"])}, '
        f"{escape(record['route'])}, p {record['p']:.2f}: {escape(answered)}</span>; "
        f'<span class="right">right: {escape(right)}</span></p>'
        f'<p class="note">{escape(record["reason"])}</p><div class="row">{figures}</div></div>'
    )


def _class_of(says: str) -> str:
    return "right" if says == "right" else "wrong"


def _maps(sheets: Mapping[str, str]) -> Iterator[str]:
    figures = (
        f'<figure><img src="{uri}" alt="map of {escape(name)}"><figcaption>{escape(name)}'
        "</figcaption></figure>"
        for name, uri in sheets.items()
    )
    yield f'<div class="maps">{"".join(figures)}</div>'


def _section(title: str, parts: Iterable[str]) -> str:
    return f"<h2>{escape(title)}</h2>\n" + "\n".join(parts)


def _table(table: Table) -> str:
    heads = "".join(_cell("th", name, n < table.texts) for n, name in enumerate(table.columns))
    rows = "\n".join(f"<tr>{_row(row, table.texts)}</tr>" for row in table.rows)
    title = f"<h3>{escape(table.title)}</h3>" if table.title else ""
    return f'{title}<div class="wide"><table><tr>{heads}</tr>\n{rows}</table></div>'


def _row(row: Sequence[str], texts: int) -> str:
    return "".join(_cell("td", value, n < texts) for n, value in enumerate(row))


def _cell(tag: str, value: str, is_text: bool) -> str:
    kind = ' class="text"' if is_text else ""
    return f"<{tag}{kind}>{escape(value)}</{tag}>"


def _figure(picture: str, says: str) -> str:
    return f"<figure>{picture}<figcaption>{escape(says)}</figcaption></figure>"


def _note(text: str) -> str:
    return f'<p class="note">{escape(text)}</p>'


def _notes(lines: Iterable[str]) -> str:
    return "".join(map(_note, lines))
