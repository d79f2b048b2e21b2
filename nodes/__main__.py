"""``python -m sceneq_nodes [KIND]``: one node of the graph, or the router, in this process."""

from sceneq_nodes._lifecycle import end
from sceneq_nodes._process import main

if __name__ == "__main__":
    end(main())
