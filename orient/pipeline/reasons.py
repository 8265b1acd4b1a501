"""Why a version was made or selected: some words that `log` can show, for the command line and for Python alike."""

from orient.errors import UsageError
from orient.words import is_valid

LONGEST = 1000
EXAMPLE = 'In some words, for example "P7 was read on the wrong house".'


def check_reason(reason: object) -> None:
    """`UsageError` if it is no text, says nothing, or is a book."""
    if not isinstance(reason, str):
        raise UsageError(f"the reason {reason!r:.40} is no text", EXAMPLE)
    if not reason.strip():
        raise UsageError("say why", EXAMPLE)
    if len(reason) > LONGEST:
        raise UsageError(f"the reason is longer than {LONGEST} characters", "Say it shorter.")
    if not is_valid(reason):
        raise UsageError("the reason is not valid text (UTF-8)", "Write it in the encoding of your terminal.")
