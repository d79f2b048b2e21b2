"""The `sceneq` command: everything a person types."""
