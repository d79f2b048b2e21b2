"""``sceneq train-probe``: teach the embedded encoder names, with recordings and portraits."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sceneq_tools.evaluation.retrieval_command import GraphFile
from sceneq_tools.progress import Quiet, progress

if TYPE_CHECKING:
    from sceneq_tools.evaluation.retrieval_setup import Setup
    from sceneq_tools.probe_examples import Example


def run(
    recordings: Annotated[
        list[Path],
        typer.Argument(metavar="FOLDER...", help="Made by sceneq synth or sceneq portraits."),
    ],
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="What to write.")] = Path(
        "probe.npz"
    ),
    graph: GraphFile = None,
    withhold: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=4,
            metavar="K",
            help="Teach without the models of furniture in this quarter, 1 to 4.",
        ),
    ] = None,
    rounds: Annotated[int, typer.Option(min=1, help="Over all examples.")] = 15,
    quiet: Quiet = False,
) -> None:
    """Write what the names in recordings look like, how large they are and what they mean.

    The file goes into the graph, alike in encoding and routing: encoder: {kind: conse, probe: FILE}
    With --withhold the names stay, but models of one quarter do not teach: to such a file they are
    strangers, and sceneq calibrate --strangers FOLDER sees how it does with them.
    """
    from sceneq_nodes._conse_encoder import ConseEncoder
    from sceneq_nodes._probe_file import write_probe
    from sceneq_tools.errors import UserError
    from sceneq_tools.evaluation.retrieval_setup import open_setup
    from sceneq_tools.probe_examples import digest, without_quarter
    from sceneq_tools.probe_lessons import learn, meanings

    setup = open_setup(graph)
    encoder = setup.encoder
    if not isinstance(encoder, ConseEncoder):
        raise UserError(f"the graph's encoder is {encoder.model_id}: only conse has a probe", 2)
    found = [example for folder in recordings for example in _examples(folder, setup, quiet)]
    if not found:
        raise UserError("no thing is seen in these recordings")
    texts = meanings(found)
    taught, withheld = without_quarter(found, withhold)
    if not taught:
        raise UserError(f"nothing to learn: all that is seen is of quarter {withhold}")
    try:
        lessons = learn(taught, texts, encoder.embed_all, rounds)
    except ValueError as error:
        raise UserError(f"nothing to learn: {error}") from error
    out.parent.mkdir(parents=True, exist_ok=True)
    write_probe(out, lessons, [text for text, _ in texts], digest(taught), withheld)
    less = "" if withhold is None else f", {len(withheld)} models withheld"
    typer.echo(f"{len(lessons.probe)} names from {len(taught)} views{less} -> {out}")


def _examples(folder: Path, setup: "Setup", quiet: bool) -> "list[Example]":
    from sceneq_tools.probe_examples import examples

    with progress(f"looking at {folder.resolve().name}", None, "things", quiet) as advance:
        return list(examples(folder, setup, advance))
