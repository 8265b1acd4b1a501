"""What the shell offers after Tab: names of stages, lists, questions, plots, formats. Must come at once."""

from collections.abc import Callable

Completer = Callable[[str], list[tuple[str, str]]]


def from_words(words: tuple[str, ...]) -> Completer:
    """An argument that takes one of some words."""
    return lambda incomplete: [(word, "") for word in words if word.startswith(incomplete)]


def _matching(named: list[tuple[str, str]], incomplete: str) -> list[tuple[str, str]]:
    return [(name, told) for name, told in named if name.startswith(incomplete)]


def stage_names(incomplete: str) -> list[tuple[str, str]]:
    """Lists and computed stages, with what they are."""
    from orient.pipeline.registry import ALL_STAGES, BY_NAME, EVIDENCE

    told = {name: stage.title for name, stage in BY_NAME.items()} | {EVIDENCE: "verifications"}
    return _matching([(name, told.get(name, "list")) for name in (*ALL_STAGES, EVIDENCE)], incomplete)


def list_names(incomplete: str) -> list[tuple[str, str]]:
    """Lists that can be added."""
    from orient.pipeline.registry import INPUT_STAGES

    return _matching([(name, "") for name in INPUT_STAGES], incomplete)


def question_names(incomplete: str) -> list[tuple[str, str]]:
    """Ready-made questions, with what they ask."""
    from orient.report.questions import QUESTIONS

    return _matching([(question.name, question.asks) for question in QUESTIONS], incomplete)


def plot_names(incomplete: str) -> list[tuple[str, str]]:
    """Kinds of plots, with what they show."""
    from orient.report.plots import PLOTS

    return _matching([(plot.name, plot.shows) for plot in PLOTS], incomplete)


def format_names(incomplete: str) -> list[tuple[str, str]]:
    """Formats of export, with what they hold."""
    from orient.export import FORMATS

    return _matching([(form.name, form.holds) for form in FORMATS], incomplete)
