"""Several questions at once: python follow.py tcp/127.0.0.1:7447 "red ball" table."""

import asyncio
import sys

from sceneq_client import AsyncSceneQ


async def main(endpoint: str, *wanted: str) -> None:
    """Print an answer for each, in the order of the questions."""
    async with AsyncSceneQ(endpoint) as scene:
        answers = await asyncio.gather(*(scene.ask(one) for one in wanted))
        for answer in answers:
            print(f"{answer.question}: {answer.status}, {answer.said}")


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
