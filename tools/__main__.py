"""``python -m sceneq_tools`` is ``sceneq``."""

from sceneq_tools.cli import main

main()
