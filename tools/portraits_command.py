"""``sceneq portraits``: pictures of single household things, to teach their names with."""

from pathlib import Path
from typing import Annotated

import typer

from sceneq_tools.progress import Quiet, progress

STREAM_ROOM, STREAM_ORDER = 7, 8
"""Independent streams of chance."""


def run(
    out: Annotated[Path, typer.Argument(help="Folder to write into.")],
    rooms: Annotated[int, typer.Option(min=1, help="How many; 82 show every model once.")] = 164,
    first: Annotated[int, typer.Option(min=0, help="Number of the first room.")] = 0,
    models: Annotated[int, typer.Option(min=1, help="Things in a room.")] = 8,
    views: Annotated[int, typer.Option(min=1, help="Portraits of a thing.")] = 3,
    quiet: Quiet = False,
) -> None:
    """Portray the models of the package sweethome3d-furniture, painted and lit by chance.

    What is portrayed does not depend on which rooms are made in one go. Teach with them:
    sceneq train-probe FOLDER --out probe.npz
    """
    import numpy as np

    from sceneq_tools.errors import UserError
    from sceneq_tools.room.models.libraries import PACKAGE_HINT, furniture_folder
    from sceneq_tools.room.models.sweet_home import SweetHomeLibrary
    from sceneq_tools.room.portrait.album import keep
    from sceneq_tools.room.portrait.photographer import portraits
    from sceneq_tools.room.portrait.sitters import sitters
    from sceneq_tools.room.portrait.stage import stage

    try:
        library = SweetHomeLibrary(furniture_folder())
    except ValueError as error:
        raise UserError(f"{error} ({PACKAGE_HINT})", 2) from error
    everyone = sitters(library)
    out.mkdir(parents=True, exist_ok=True)
    taken = 0
    with progress("portraits", rooms, "rooms", quiet) as advance:
        for number in range(first, first + rooms):
            start = number * models
            turn = np.random.default_rng((STREAM_ORDER, start // len(everyone)))
            order = turn.permutation(len(everyone))
            rows = [order[(start + k) % len(everyone)] for k in range(models)]
            rng = np.random.default_rng((STREAM_ROOM, number))
            room, posed = stage(library, [everyone[row] for row in rows], number, rng)
            shots = list(portraits(room, posed, views, rng))
            keep(out, number, shots)
            library.forget_meshes()
            taken += len(shots)
            advance()
    typer.echo(f"{taken} portraits of {rooms} rooms -> {out}")
