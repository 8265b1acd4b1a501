"""Words: a number with its noun, a name as a shell takes it, whether a text can be stored."""

import os
import shlex


def counted(number: int, thing: str, many: str = "") -> str:
    """`1 point`, `3 points`."""
    return f"{number} {thing if number == 1 else many or thing + 's'}"


def typed(path: str | os.PathLike[str]) -> str:
    """The path as one word of a command line: quoted for the shell, and not to be taken for an option."""
    name = os.fspath(path)
    return shlex.quote(f"./{name}" if name.startswith("-") else name)


def is_valid(text: str) -> bool:
    """No half of a letter is in it, which stands for a byte that is no text and cannot be stored."""
    return text.isascii() or not any("\ud800" <= letter <= "\udfff" for letter in text)
