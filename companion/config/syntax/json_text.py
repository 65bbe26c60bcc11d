"""JSON -> plain data that remembers the line of every key, as ``document`` does for YAML."""

from __future__ import annotations

import json
import math
import re
from typing import Any

from companion.config.syntax.document import DEPTH_MAX, Document
from companion.config.syntax.faults import ConfigError, Fault, Key, dotted

_TOKEN = re.compile(r'[ \t\r\n]*(?:([\[\]{},:])|("(?:[^"\\\x00-\x1f]|\\.)*")|([^\s\[\]{},:"]+)|([^ \t\r\n]))')
_NUMBER = re.compile(r"-?(?:0|[1-9][0-9]*)(?:\.[0-9]+)?(?:[eE][-+]?[0-9]+)?$")
_WORDS = {"true": True, "false": False, "null": None}
_END = "the end of the file"


def parse_json(text: str, file: str) -> Document:
    """The document in ``text``. ConfigError: it is not JSON, says a key twice, or a number that is not finite."""
    text = text.removeprefix("\ufeff")
    try:
        data = json.loads(text, object_pairs_hook=_once, parse_float=_finite, parse_constant=_finite)
        if _depth(data) <= DEPTH_MAX:
            return Document(file, data, _Lines(text, file))
    except (ValueError, RecursionError):
        pass
    return _Reader(text, file).document()  # says what is wrong, and where


class _Lines(dict[Key, int]):
    """The lines of a document that is in order, looked up when first asked for: a plan of ten thousand waypoints takes
    seconds to walk through in Python, and is seldom wrong."""

    def __init__(self, text: str, file: str) -> None:
        super().__init__()
        self._source = (text, file)

    def __contains__(self, key: object) -> bool:
        return super().__contains__(key) or (not self and self._filled() and super().__contains__(key))

    def __getitem__(self, key: Key) -> int:
        return super().__getitem__(key) if self or self._filled() else 1

    def _filled(self) -> bool:
        self.update(_Reader(*self._source).document().lines)
        return True


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    mapping = dict(pairs)
    if len(mapping) < len(pairs):
        raise ValueError("a key given twice")
    return mapping


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError("not finite")
    return value


def _depth(data: Any) -> int:
    depth, level = 0, [data] if isinstance(data, dict | list) else []
    while level:
        depth += 1
        level = [x for part in level for x in (part.values() if isinstance(part, dict) else part)
                 if isinstance(x, dict | list)]  # fmt: skip
    return depth


class _Reader:
    """One pass over the tokens."""

    def __init__(self, text: str, file: str) -> None:
        self._text, self._file = text, file
        self._lines: dict[Key, int] = {(): 1}
        self._at, self._line = 0, 1
        self._punctuation: str | None = None
        self._string: str | None = None
        self._word: str | None = None

    def document(self) -> Document:
        """All of it."""
        self._next()
        data = self._value(())
        if not self._ended:
            raise self._wrong(f"{self._found} after the end of the document")
        return Document(self._file, data, self._lines)

    def _value(self, key: Key) -> Any:
        if len(key) > DEPTH_MAX:
            raise self._wrong(f"nested deeper than {DEPTH_MAX} levels")
        if self._string is not None:
            return self._text_value(key)
        if self._word is not None:
            return self._word_value(key)
        if self._punctuation == "{":
            return self._mapping(key)
        if self._punctuation == "[":
            return self._list(key)
        raise self._wrong(f"{self._found}; expected a value", key)

    def _mapping(self, key: Key) -> dict[str, Any]:
        mapping: dict[str, Any] = {}
        self._next()
        while self._punctuation != "}":
            line = self._line
            if self._string is None:
                raise self._wrong(f'{self._found}; expected a key in double quotes, or "}}"', key)
            name = self._text_value(key)
            inner = (*key, name)
            if name in mapping:
                message = f"given twice, first on line {self._lines[inner]}; expected once"
                raise ConfigError([Fault(self._file, line, dotted(inner), message)])
            self._lines[inner] = line
            if self._punctuation != ":":
                raise self._wrong(f'{self._found} after the key; expected ":"', inner)
            self._next()
            mapping[name] = self._value(inner)
            self._expect_separator("}", key)
        self._next()
        return mapping

    def _list(self, key: Key) -> list[Any]:
        items: list[Any] = []
        self._next()
        while self._punctuation != "]":
            inner = (*key, len(items))
            self._lines[inner] = self._line
            items.append(self._value(inner))
            self._expect_separator("]", key)
        self._next()
        return items

    def _expect_separator(self, end: str, key: Key) -> None:
        if self._punctuation == ",":
            self._next()
            if self._punctuation == end:
                raise self._wrong(f'a comma before "{end}"', key)
        elif self._punctuation != end:
            raise self._wrong(f'{self._found}; expected "," or "{end}"', key)

    def _text_value(self, key: Key) -> str:
        assert self._string is not None
        try:
            text = json.loads(self._string)
        except ValueError:
            raise self._wrong("text with a wrong escape", key) from None
        self._next()
        return str(text)

    def _word_value(self, key: Key) -> Any:
        word = self._word or ""
        if word in _WORDS:
            value: Any = _WORDS[word]
        elif _NUMBER.match(word):
            value = float(word) if len(word) > 18 or not word.lstrip("-").isdigit() else int(word)
            if not math.isfinite(value):
                raise self._wrong(f"{self._found} is not finite", key)
        else:
            raise self._wrong(f"{self._found}; expected a number, text, true, false or null", key)
        self._next()
        return value

    @property
    def _ended(self) -> bool:
        return self._punctuation is None and self._string is None and self._word is None

    @property
    def _found(self) -> str:
        found = _END if self._ended else self._punctuation or self._string or self._word or ""
        found = found if found.isprintable() else ascii(found)
        return found if len(found) <= 40 else found[:37] + "..."

    def _next(self) -> None:
        match = _TOKEN.match(self._text, self._at)
        if match is None:  # nothing but space is left
            self._line += self._text.count("\n", self._at)
            self._at = len(self._text)
            self._punctuation = self._string = self._word = None
            return
        begin = match.end() - len(match.group(match.lastindex or 0))
        self._line += self._text.count("\n", self._at, begin)
        self._at = match.end()
        self._punctuation, self._string, self._word, other = match.groups()
        if other is not None:
            what = "text that is not closed" if other == '"' else f"the character {other!r}"
            raise self._wrong(what)

    def _wrong(self, message: str, key: Key = ()) -> ConfigError:
        return ConfigError([Fault(self._file, self._line, dotted(key), f"not valid JSON: {message}")])
