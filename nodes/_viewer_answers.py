"""The last answers in a Rerun recording: what was asked, what was found, and why."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sceneq_core.mapping.replica import MapReplica
from sceneq_nodes._viewer_map import instance_boxes

Json = Mapping[str, Any]

ANSWERS, MARKED = "answers/text", "world/answer"
EVIDENCE = ("answers/evidence/1", "answers/evidence/2", "answers/evidence/3")
MARK_RGB, OTHER_RGB = (255, 40, 40), (255, 190, 60)
MARK_RADIUS_M = 0.012
MARKED_MATCHES = 3
SHOWN = ("found", "ambiguous")
LISTED = 8
NOTHING = 'No question yet. Ask one:\n\n    sceneq ask "red mug"\n'


def answers_text(newest: Json | None, earlier: Sequence[Json]) -> str:
    """Return the newest answer with its scores and those before it, as Markdown."""
    if newest is None:
        return NOTHING
    lines = [f"### {newest['question']}", "", f"**{newest['status']}** by the {newest['route']} "]
    lines[-1] += f"route in {newest['took_ms']:.0f} ms: {newest['reason']}"
    lines += ["", "| id | what | p | cosine | views |", "|---|---|---|---|---|"]
    for match in newest["instances"][:MARKED_MATCHES]:
        views = ", ".join(str(view["seq"]) for view in match["views"][: len(EVIDENCE)])
        what = match["label"] or "-"
        lines.append(
            f"| {match['id']} | {what} | {match['p']:.2f} | {match['cosine']:.2f} | {views} |"
        )
    if earlier:
        lines += ["", "| before | found | p | route | ms |", "|---|---|---|---|---|"]
        lines += [_row(record) for record in earlier[:LISTED]]
    return "\n".join(lines)


def _row(record: Json) -> str:
    best = record["best"][0] if record["best"] else None
    found = f"{best['id']} {best['label']} | {best['p']:.2f}" if best else "- | -"
    head = f"| {record['question']} ({record['status']}) | {found}"
    return f"{head} | {record['route']} | {record['took_ms']:.0f} |"


class AnswersLog:
    """Logs answers into one recording."""

    def __init__(self, recording: Any) -> None:
        self._recording = recording
        self.text(None, ())

    def text(self, newest: Json | None, earlier: Sequence[Json]) -> None:
        """Log the list of answers."""
        import rerun as rr

        text = answers_text(newest, earlier)
        self._shown = rr.TextDocument(text, media_type="text/markdown")
        self.repeat()

    def repeat(self) -> None:
        """Log the list of answers again."""
        self._recording.log(ANSWERS, self._shown)

    def evidence(self, answer: Json, pictures: Sequence[bytes | None]) -> None:
        """Log the pictures of the best instance's views with its box; the others go blank."""
        import rerun as rr

        best = answer["instances"][0] if answer["instances"] else {"views": ()}
        for path in EVIDENCE:
            self._recording.log(path, rr.Clear(recursive=True))
        for path, view, jpeg in zip(EVIDENCE, best["views"], pictures, strict=False):
            if jpeg is None:
                continue
            self._recording.log(path, rr.EncodedImage(contents=jpeg, media_type="image/jpeg"))
            box = rr.Boxes2D(
                array=[view["box_xyxy"]],
                array_format=rr.Box2DFormat.XYXY,
                colors=[MARK_RGB],
                radii=1.5,
                labels=[f"{best['id']}  p {best['p']:.2f}"],
            )
            self._recording.log(f"{path}/box", box)

    def mark(self, answer: Json, replica: MapReplica) -> None:
        """Log bold boxes round the best matches, the first one red."""
        matches = [
            match
            for match in answer["instances"][:MARKED_MATCHES]
            if match["id"] in replica.instances and answer["status"] in SHOWN
        ]
        instances = [replica.instances[match["id"]] for match in matches]
        texts = [f"{m['id']} {m['label']}  p {m['p']:.2f}" for m in matches]
        colours = np.array([MARK_RGB, *[OTHER_RGB] * MARKED_MATCHES], np.uint8)[: len(matches)]
        boxes = instance_boxes(instances, texts, MARK_RADIUS_M, colours)
        self._recording.log(MARKED, boxes)
