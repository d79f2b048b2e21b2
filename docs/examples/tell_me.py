"""Be told when something appears: python tell_me.py tcp/127.0.0.1:7447 "red ball" 0.2."""

import sys

from sceneq_client import SceneQ


def main(endpoint: str, wanted: str, min_p: str) -> None:
    """Print the first thing that answers, whether it is there already or comes later."""
    with SceneQ(endpoint) as scene, scene.watch(wanted, min_p=float(min_p)) as sightings:
        for sighting in sightings:
            one = sighting.instance
            print(f"{sighting.question}: {one.id} at {one.centre_world}, p {one.p:.2f}")
            break


if __name__ == "__main__":
    main(*sys.argv[1:4])
