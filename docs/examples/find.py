"""Find a thing and drive to it: python find.py tcp/127.0.0.1:7447 "red ball"."""

import sys

from sceneq_client import SceneQ


def main(endpoint: str, wanted: str) -> None:
    """Print where the thing is, or why that is not known."""
    with SceneQ(endpoint) as scene:
        answer = scene.ask(wanted)
        if answer.best is None:
            print(f"not here: {answer.said}")
        elif answer.status == "ambiguous":
            choices = ", ".join(f"{one.id} (p {one.p:.2f})" for one in answer.instances)
            print(f"which one? {choices}")
        else:
            x, y, z = answer.best.centre_world
            print(f"go to {x:.2f} {y:.2f} {z:.2f}: {answer.said}")
        if answer.best is not None and answer.best.views:
            jpeg = scene.picture(answer.best.views[0])
            print(f"evidence: {len(jpeg)} bytes of JPEG, box {answer.best.views[0].box_xyxy}")


if __name__ == "__main__":
    main(*sys.argv[1:3])
