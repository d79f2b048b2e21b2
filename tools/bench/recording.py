"""A recording run through the nodes in this process, for the benches that need a map."""

from sceneq_tools.batch import Batch
from sceneq_tools.bench.measurement import Options
from sceneq_tools.errors import UserError
from sceneq_tools.graph_plan import Plan
from sceneq_tools.progress import progress


def open_batch(options: Options) -> Batch:
    """Return the graph on ``options.source``, before its first frame; raise like ``open_plan``."""
    return Batch(open_plan(options))


def open_plan(options: Options) -> Plan:
    """Return what to run on ``options.source``.

    Raises:
        UserError: no source, or one that cannot be read.
    """
    from sceneq_tools.graph import default_path, load
    from sceneq_tools.graph_check import check_nodes
    from sceneq_tools.graph_plan import plan
    from sceneq_tools.up_command import source_overrides

    if options.source is None:
        raise UserError("a folder of frames is needed: --source FOLDER", 2)
    overrides = source_overrides(options.source, None, 0.0, None, False, False, None)
    loaded, document = load(options.graph or default_path(), overrides)
    check_nodes(loaded, document)
    return plan(loaded, document, "local")


def play(batch: Batch, options: Options) -> int:
    """Run it to the end, or to ``options.frames``; return how many frames were played."""
    played = 0
    for stage in batch.stages():
        is_frames = stage.name == "frames"
        last = options.frames if is_frames else None
        with progress(stage.name, last or stage.total, quiet=options.quiet) as advance:
            done = 0
            for now in stage.steps:
                advance(now - done)
                done = now
                if last is not None and done >= last:
                    break
        played = done if is_frames else played
    return played
