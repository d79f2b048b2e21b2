"""``python -m sceneq_tools`` is ``sceneq``."""

from sceneq_tools.cli import main

if __name__ == "__main__":
    main()
