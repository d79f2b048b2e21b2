"""A YAML file whose every value knows its line, and what the command line put over it."""

from collections.abc import Hashable
from pathlib import Path
from typing import Any

import yaml

from sceneq_tools.graph_problem import GraphError, Problem

Key = str | int
KeyPath = tuple[Key, ...]


class Document:
    """The plain values of a YAML file, and where each of them was written.

    Raises:
        GraphError: not readable, not YAML, a key twice, or no mapping at the top.
    """

    def __init__(self, path: Path) -> None:
        self.name = path.name
        self._options: dict[KeyPath, str] = {}
        self._root = self._parse(_read(path))
        self.values: dict[str, Any] = self._constructed()

    def override(self, path: KeyPath, value: Any, option: str) -> None:
        """Set the value at ``path``, making the mappings on the way; ``option`` is to blame."""
        at: Any = self.values
        for key in path[:-1]:
            at = _enter(at, key)
        at[path[-1]] = value
        self._options[path] = option

    def where(self, path: KeyPath) -> str:
        """Return ``--option`` or ``file:line`` of the value at ``path`` or its nearest parent."""
        for end in range(len(path), 0, -1):
            if option := self._options.get(path[:end]):
                return option
            if node := self._find(path[:end]):
                return f"{self.name}:{node.start_mark.line + 1}"
        return f"{self.name}:1"

    def _constructed(self) -> Any:
        try:
            return yaml.SafeLoader("").construct_document(self._root)
        except yaml.MarkedYAMLError as error:
            raise self._not_yaml(error) from error

    def _parse(self, text: str) -> yaml.Node:
        try:
            root = yaml.compose(text, Loader=yaml.SafeLoader)
        except yaml.MarkedYAMLError as error:
            raise self._not_yaml(error) from error
        except (yaml.YAMLError, RecursionError) as error:
            raise self._error(1, "", f"not YAML: {error}") from error
        if not isinstance(root, yaml.MappingNode):
            raise self._error(1, "", "expected 'key: value' lines")
        self._reject_twins(root, set())
        return root

    def _reject_twins(self, node: yaml.Node, looked_at: set[int]) -> None:
        """YAML keeps the last of two equal keys and says nothing; we say it.

        A node may stand in many places, by its aliases, and even in itself.
        """
        if id(node) in looked_at:
            return
        looked_at.add(id(node))
        if isinstance(node, yaml.SequenceNode):
            for item in node.value:
                self._reject_twins(item, looked_at)
        if not isinstance(node, yaml.MappingNode):
            return
        seen: set[Hashable] = set()
        for key, value in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise self._error(key.start_mark.line + 1, "", "a key must be plain text")
            if key.value in seen:
                raise self._error(key.start_mark.line + 1, key.value, "written twice")
            seen.add(key.value)
            self._reject_twins(value, looked_at)

    def _find(self, path: KeyPath) -> yaml.Node | None:
        """Return the node that shows where ``path`` is written: its key, or its list item."""
        shown: yaml.Node | None = None
        at: yaml.Node | None = self._root
        for key in path:
            shown, at = _child(at, key)
            if shown is None:
                return None
        return shown

    def _not_yaml(self, error: yaml.MarkedYAMLError) -> GraphError:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        return self._error(line, "", f"not YAML: {error.problem}")

    def _error(self, line: int, path: str, message: str) -> GraphError:
        return GraphError([Problem(f"{self.name}:{line}", path, message)])


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8 text"
        raise GraphError([Problem(str(path), "", reason, hint="name a graph file")]) from error


def _enter(at: Any, key: Key) -> Any:
    if isinstance(at, dict) and not isinstance(at.get(key), dict | list):
        at[key] = {}
    return at[key]


def _child(node: yaml.Node | None, key: Key) -> tuple[yaml.Node | None, yaml.Node | None]:
    if isinstance(node, yaml.MappingNode):
        for name, value in node.value:
            if name.value == str(key):
                return name, value
    if isinstance(node, yaml.SequenceNode) and isinstance(key, int) and key < len(node.value):
        return node.value[key], node.value[key]
    return None, None
