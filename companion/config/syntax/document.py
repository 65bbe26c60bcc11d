"""YAML -> plain data that remembers the line of every key.

Numbers and booleans follow YAML 1.2's core schema: ``1e3`` is a number, ``12:30``, ``yes`` and ``on`` are text.
Duplicate keys, anchors and tags are faults: a file that flies a machine says everything once, in the open.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

import yaml

from companion.config.syntax.faults import ConfigError, Fault, Key, dotted

_INT = re.compile(r"[-+]?[0-9]+$|0o[0-7]+$|0x[0-9a-fA-F]+$")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?$")
_WORDS = {
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"), math.inf),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), -math.inf),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), math.nan),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
}
DEPTH_MAX = 20
"""lists and mappings inside one another (engineering choice)."""


@dataclass(frozen=True, slots=True)
class Document:
    """A parsed file: ``data`` plain (dict, list, str, int, float, bool, None), ``lines`` the line of every key."""

    file: str
    data: Any
    lines: dict[Key, int]

    def line(self, key: Key) -> int:
        """The line of ``key``, or of the nearest key above it that the file has."""
        while key not in self.lines:
            key = key[:-1]
        return self.lines[key]

    def fault(self, key: Key, message: str) -> Fault:
        """A fault at ``key``."""
        return Fault(self.file, self.line(key), dotted(key), message)


def scalar(text: str) -> Any:
    """A plain (unquoted) YAML 1.2 scalar as a value."""
    if text in _WORDS:
        return _WORDS[text]
    if _INT.match(text):
        return int(text, 0) if text.startswith(("0o", "0x")) else int(text) if len(text) < 20 else float(text)
    if _FLOAT.match(text):
        return float(text)
    return text


_WORDS_FOR = {
    "expected '<document start>'": "this line is indented otherwise than the lines before it",
    "expected <block end>": "this line is indented otherwise than the lines before it",
    "mapping values are not allowed": "a second colon on one line, or a line that is indented too far",
    "could not find expected ':'": "a key without a colon, or text that goes on on the next line",
    "expected ',' or '}'": "a comma or a closing } is missing here",
    "expected ',' or ']'": "a comma or a closing ] is missing here",
    "that cannot start any token": "a character that nothing begins with (a tab, %, @ or `); put text into quotes",
    "unexpected end of stream": "a quote that is not closed",
}


def _in_words(error: yaml.MarkedYAMLError) -> str:
    """What YAML's own parser says, for people who have not read its grammar."""
    said = " ".join(filter(None, (error.context, error.problem)))
    return next((words for problem, words in _WORDS_FOR.items() if problem in said), said)


def parse(text: str, file: str) -> Document:
    """The document in ``text``. ConfigError: not YAML, or one of the faults above."""
    faults: list[Fault] = []
    lines: dict[Key, int] = {(): 1}
    try:
        for token in yaml.scan(text, Loader=yaml.SafeLoader):
            if isinstance(token, yaml.AnchorToken | yaml.AliasToken | yaml.TagToken):
                what = {"AnchorToken": "an anchor (&)", "AliasToken": "an alias (*)", "TagToken": "a tag (!)"}
                name = what[type(token).__name__]
                faults.append(Fault(file, token.start_mark.line + 1, "", f"{name} is not allowed; write the value out"))
        if faults:
            raise ConfigError(faults)
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = mark.line + 1 if mark is not None else 1
        raise ConfigError([Fault(file, line, "", f"not valid YAML: {_in_words(error)}")]) from None
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        message = f"not valid YAML: the character {text[error.position]!a} is not allowed"
        raise ConfigError([Fault(file, line, "", message)]) from None
    except RecursionError:
        raise ConfigError([Fault(file, 1, "", f"nested deeper than {DEPTH_MAX} levels")]) from None

    def build(node: yaml.Node, key: Key) -> Any:
        if len(key) > DEPTH_MAX:
            faults.append(Fault(file, node.start_mark.line + 1, dotted(key), f"nested deeper than {DEPTH_MAX} levels"))
            return None
        if isinstance(node, yaml.MappingNode):
            mapping: dict[str, Any] = {}
            for key_node, value_node in node.value:
                line = key_node.start_mark.line + 1
                if not isinstance(key_node, yaml.ScalarNode):
                    faults.append(Fault(file, line, dotted(key), "a key must be a word, not a list or a mapping"))
                    continue
                name = str(key_node.value)
                inner = (*key, name)
                if name in mapping:
                    first = lines[inner]
                    message = f"given twice, first on line {first}; expected once"
                    faults.append(Fault(file, line, dotted(inner), message))
                    continue
                lines[inner] = line
                mapping[name] = build(value_node, inner)
            return mapping
        if isinstance(node, yaml.SequenceNode):
            items = []
            for index, item in enumerate(node.value):
                lines[(*key, index)] = item.start_mark.line + 1
                items.append(build(item, (*key, index)))
            return items
        assert isinstance(node, yaml.ScalarNode)
        return scalar(node.value) if node.style is None else node.value

    data = None if root is None else build(root, ())
    if faults:
        raise ConfigError(faults)
    return Document(file, data, lines)
