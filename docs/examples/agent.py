"""Call the scene's tools as an agent's host does: python agent.py tcp/127.0.0.1:7447 "red ball"."""

import asyncio
import sys

from mcp import Client, StdioServerParameters


async def main(endpoint: str, question: str) -> None:
    """Print the tools, and what `ask` says."""
    arguments = ["-m", "sceneq_tools", "mcp", "--connect", endpoint]
    async with Client(StdioServerParameters(command=sys.executable, args=arguments)) as host:
        tools = await host.list_tools()
        print("tools:", ", ".join(sorted(tool.name for tool in tools.tools)))
        result = await host.call_tool("ask", {"question": question})
        print(result.structured_content)


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:3]))
