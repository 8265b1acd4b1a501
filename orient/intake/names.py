"""Names of points, marks, crosses, sheets and zones: letters, digits, space and . _ - +, at most 64 characters."""

import unicodedata
from dataclasses import dataclass, field

from orient.intake.findings import BadValue, Findings, shown

LONGEST_NAME = 64
MOST_TWINS = 100
PUNCTUATION = " ._-+"
FORMULA_STARTS = "=+-@"

LATIN_OF = str.maketrans(
    "АВСЕНІЈКМОРЅТХУаеіјорсухѕԁɡ" + "ΑΒΕΖΗΙΚΜΝΟΡΤΥΧοινρ",
    "ABCEHIJKMOPSTXYaeijopcyxsdg" + "ABEZHIKMNOPTYXoivp",
)
"""Letters of the Cyrillic and Greek alphabets that look like Latin ones."""


def parse_name(text: str) -> str:
    """The name in Unicode form NFC. Raises `BadValue`."""
    name = without_formula_guard(text)
    if not name.strip():
        raise BadValue("name is missing")
    if len(name) > LONGEST_NAME:
        raise BadValue(f'name "{shown(name)}" is longer than {LONGEST_NAME} characters')
    if name != name.strip():
        raise BadValue(f'name "{shown(name)}" begins or ends with a space')
    for character in name:
        if character not in PUNCTUATION and unicodedata.category(character)[0] not in "LM" and not _is_digit(character):
            raise BadValue(f"contains {_described(character)}; allowed are letters, digits, space and . _ - +")
    return unicodedata.normalize("NFC", name)


def without_formula_guard(text: str) -> str:
    """Takes back the ' that a CSV export of orient puts before = + - @ to keep spreadsheets from calculating."""
    return text[1:] if len(text) > 1 and text[0] == "'" and text[1] in FORMULA_STARTS else text


@dataclass(slots=True)
class NameRegister:
    """The names seen in one file: the same name in two Unicode forms is refused, look-alikes are reported once."""

    file: str
    kind: str
    findings: Findings
    _written: dict[str, tuple[str, int]] = field(default_factory=dict)
    _alike: dict[str, tuple[str, int]] = field(default_factory=dict)
    _twins: int = 0

    def add(self, text: str, line: int) -> str:
        """The name in form NFC; raises `BadValue`."""
        name = parse_name(text)
        written = without_formula_guard(text)
        first, first_line = self._written.setdefault(name, (written, line))
        if first != written:
            raise BadValue(
                f'{self.kind} "{shown(name)}" is the same name as in line {first_line} in another Unicode form'
            )
        if first_line == line:
            self._look_for_twin(name, line)
        return name

    def _look_for_twin(self, name: str, line: int) -> None:
        shape = unicodedata.normalize("NFKC", name).translate(LATIN_OF).casefold()
        other, other_line = self._alike.setdefault(shape, (name, line))
        if other == name or self._twins >= MOST_TWINS:
            return
        self._twins += 1
        codes = [f"U+{ord(a):04X} and U+{ord(b):04X}" for a, b in zip(other, name, strict=False) if a != b]
        message = (
            f'{self.file}: {self.kind} "{shown(other)}" (line {other_line}) and "{shown(name)}" (line {line}) look '
            f"alike but are different names ({codes[0] if codes else 'different letters'})"
        )
        self.findings.warn("look_alike", name, message)


def _is_digit(character: str) -> bool:
    return unicodedata.category(character) == "Nd"


def _described(character: str) -> str:
    return f"U+{ord(character):04X}" if not character.isascii() or not character.isprintable() else f'"{character}"'
