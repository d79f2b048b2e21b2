"""Pages that are made from the code itself, so that they cannot be wrong."""

import dataclasses
import inspect
import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, get_type_hints

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from sceneq_nodes import NODES
from sceneq_nodes._backends import BACKENDS
from sceneq_schemas.topics import TOPICS, Delivery, Topic

SIZES = ((1 << 20, "MiB"), (1 << 10, "KiB"))
ROOT = Path(__file__).parents[2]


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages."""
    pages = {
        "configuration.md": configuration(),
        "messages.md": messages(),
        "adr/index.md": decisions(),
    }
    for name, text in pages.items():
        files.append(File.generated(config, name, content=text))
    return files


def configuration() -> str:
    """Return every parameter of every node and backend, from their classes."""
    parts = [
        "# Configuration",
        "What may stand under `params:` in `graph.yaml`. `sceneq check graph.yaml` says what is "
        "wrong and in which line. What names a `kind` takes the parameters of that kind "
        "beside it.",
        "## Nodes",
    ]
    for kind, path in NODES.items():
        parts += _section(f"`{kind}`", loaded(path))
    for group, kinds in BACKENDS.items():
        if group == "nodes":
            continue
        parts.append(f"## Kinds of {group.replace('_', ' ')}")
        for kind, path in kinds.items():
            parts += _section(f"{group} `{kind}`", loaded(path))
    return "\n\n".join(parts) + "\n"


def loaded(path: str) -> Any:
    """Return what ``module:Class`` names."""
    module, _, name = path.partition(":")
    return getattr(import_module(module), name)


def _section(title: str, kind: Any) -> list[str]:
    params = getattr(kind, "Params", None)
    about = _first_lines(inspect.getdoc(kind) or "")
    rows = list(_rows(params)) if params is not None else []
    table = ["| parameter | type | default |", "|---|---|---|", *rows] if rows else []
    explained = _first_lines(inspect.getdoc(params) or "") if rows else ""
    return [f"### {title}", about, explained, "\n".join(table) or "No parameters."]


def _rows(params: Any, prefix: str = "", depth: int = 0) -> Iterator[str]:
    """Yield a line for each field, those of dataclasses inside it as ``outer.inner``."""
    if not dataclasses.is_dataclass(params) or depth > 3:
        return
    hints = get_type_hints(params)
    for field in dataclasses.fields(params):
        kind = hints[field.name]
        if dataclasses.is_dataclass(kind):
            yield from _rows(kind, f"{prefix}{field.name}.", depth + 1)
        else:
            yield f"| `{prefix}{field.name}` | {_plain(kind)} | {_default(field)} |"


def _plain(kind: Any) -> str:
    text = kind.__name__ if isinstance(kind, type) and not hasattr(kind, "__args__") else str(kind)
    return re.sub(r"(?:[a-z_]+\.)+", "", text).replace("|", "\\|").replace("NoneType", "None")


def _default(field: Any) -> str:
    if field.default_factory is not dataclasses.MISSING:
        return f"`{field.default_factory()!r}`".replace("|", "\\|")[:80]
    return "required" if field.default is dataclasses.MISSING else f"`{field.default!r}`"


def _first_lines(text: str) -> str:
    """Return a docstring without its sections, which are for those who read code."""
    return re.split(r"\n\s*(?:Raises|Args|Attributes):", text)[0].replace("``", "`").strip()


def messages() -> str:
    """Return the table of keys, and every message field by field."""
    rows = [_topic(topic) for topic in TOPICS]
    parts = [
        "# Keys and messages",
        "`{...}` stands for a name of `[a-z0-9_-]+`. `sceneq schema` prints the same.",
        "| key | writer | data | delivery | at most |\n|---|---|---|---|---|\n" + "\n".join(rows),
        "## Delivery",
        *(f"- **{one.name.lower()}**: {one.value}" for one in Delivery),
        "## Messages",
    ]
    types = {topic.message for topic in TOPICS if topic.message is not None}
    for kind in sorted(types, key=lambda one: one.__name__):
        parts += [f"### {kind.__name__}", _first_lines(inspect.getdoc(kind) or "")]
        fields = [f"| `{f.name}` | {_plain(f.type)} |" for f in dataclasses.fields(kind)]
        parts.append("\n".join(["| field | type |", "|---|---|", *fields]))
    return "\n\n".join(parts) + "\n"


def _topic(topic: Topic) -> str:
    size = next((f"{topic.max_bytes // n} {u}" for n, u in SIZES if topic.max_bytes >= n), "")
    data = topic.message.__name__ if topic.message else topic.encoding.partition(";")[0]
    delivery = topic.delivery.name.lower()
    return f"| `{topic.pattern}` | {topic.writer} | {data} | {delivery} | {size} |"


def decisions() -> str:
    """Return the list of decision records by their titles."""
    records = sorted((ROOT / "docs" / "adr").glob("[0-9]*.md"))
    lines = [f"- [{one.read_text().splitlines()[0].lstrip('# ')}]({one.name})" for one in records]
    about = "What was decided, what else was tried, and what it measured."
    return "\n".join(["# Decisions", "", about, "", *lines]) + "\n"
