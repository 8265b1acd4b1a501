"""Every id of the bad-input catalogue has a row, or is listed here with what is still to come."""

import re
from collections.abc import Iterator
from importlib import import_module

import pytest

from tests.catalogue.test_catalogue import CASES
from tests.cli import test_bad_control
from tests.cli.commands import ROOT
from tests.store.test_opening import ACCEPTED, NEEDS_DIGEST, REFUSED

LAST = {"A": 40, "B": 19, "C": 20, "D": 40, "E": 19, "F": 14}
IDS = tuple(f"{letter}{number}" for letter, last in LAST.items() for number in range(1, last + 1))
TABLES_ELSEWHERE = (test_bad_control.NEW, test_bad_control.REFUSED, test_bad_control.SOLVED)
"""Run in their own file, which compares the geometry too."""

FUNCTIONS: dict[str, str] = {
    "A29": "tests.intake.test_bad_lists:test_A29_a_file_too_long_is_refused_in_little_memory",
    "A39": "tests.intake.test_bad_lists:test_A39_what_is_no_readable_file_is_a_usage_error",
    "A40": "tests.intake.test_bad_lists:test_A40_a_file_that_changes_while_read",
    "C6": "tests.cli.test_bad_control:test_C6_two_names_of_one_place_are_a_warning_when_read",
    "C18": "tests.cli.test_blunders:test_c18_one_of_twelve_wrong_by_100_m_is_named_and_the_others_stay",
    "C19": "tests.cli.test_blunders:test_c19_six_of_twelve_wrong_is_a_failure_without_a_result",
    "D13": "tests.store.test_mutations:test_no_damage_passes_unseen",
    "D21": "tests.catalogue.test_own_way:test_D21_a_hot_journal_in_a_read_only_folder",
    "D31": "tests.catalogue.test_own_way:test_D31_a_stored_path_is_only_text",
    "D32": "tests.catalogue.test_own_way:test_D32_the_clock_is_decoration",
    "D33": "tests.catalogue.test_own_way:test_D33_locked_by_another",
    "D34": "tests.faults.test_surroundings:test_a_read_only_project_is_not_written",
    "D35": "tests.faults.test_full_disk:test_a_file_that_may_not_grow",
    "D36": "tests.catalogue.test_own_way:test_D36_replaced_during_the_command",
    "D37": "tests.catalogue.test_own_way:test_D37_a_network_share_is_a_warning",
    "D38": "tests.cli.test_command_line:test_any_file_name_works",
    "D39": "tests.store.test_load_large:test_check_of_500_megabytes",
    "E10": "tests.catalogue.test_own_way:test_E10_bytes_do_not_go_to_a_terminal",
    "E15": "tests.cli.test_command_line:test_e15_reader_that_goes_away",
    "E16": "tests.cli.test_command_line:test_e16_no_home_no_term_c_locale",
    "E17": "tests.catalogue.test_own_way:test_E17_an_old_sqlite_is_named",
    "E18": "tests.cli.test_command_line:test_e18_interpreter_options_change_nothing",
    "E19": "tests.faults.test_crowded:test_of_several_that_make_one_name_exactly_one_wins",
    "F3": "tests.cli.test_report:test_names_that_are_markup_stay_names",
    "F4": "tests.cli.test_report:test_the_page_has_all_its_parts_and_nothing_active",
    "F5": "tests.cli.test_report:test_the_policy_allows_nothing_but_the_style_of_the_page",
    "F6": "tests.catalogue.test_own_way:test_F6_a_picture_holds_no_markup_of_a_name",
    "F9": "tests.cli.test_seal:test_a_stored_name_never_becomes_a_path",
    "F11": "tests.cli.test_plot:test_force_replaces_the_link_and_not_what_it_points_at",
    "F13": "tests.catalogue.test_own_way:test_F13_a_killed_export_leaves_no_file_or_the_old_one",
}
"""Rows that need other processes, memory limits, terminals: the tests that are these rows."""

OPEN: dict[str, str] = {
    "E4": "no command has a confidence yet",
    "F7": "Markdown: nothing writes it yet",
    "F10": "one file for each point: nothing exports so yet",
}
"""Ids without a row, and why; a row for one of them has to be taken from this list."""


def ids_of(name: str) -> str:
    found = re.match(r"[A-F]\d+", name)
    return found.group() if found else ""


def ids_with_rows() -> Iterator[str]:
    for table in (CASES, *TABLES_ELSEWHERE, REFUSED, NEEDS_DIGEST, ACCEPTED):
        yield from map(ids_of, table)
    yield from FUNCTIONS


@pytest.mark.parametrize("name", IDS)
def test_the_id_has_a_row(name: str) -> None:
    is_tested = name in set(ids_with_rows())
    if name in OPEN and not is_tested:
        pytest.skip(f"{name}: {OPEN[name]}")
    assert name not in OPEN, f"{name} has a row now; take it from OPEN"
    assert is_tested, f"{name} of the catalogue has no row"


def test_an_open_option_is_still_open() -> None:
    """E4 waits for the first command that takes a confidence."""
    page = (ROOT / "docs" / "cli.md").read_text(encoding="utf-8")
    assert ("--confidence" in page) == ("E4" not in OPEN)


def test_no_row_has_an_id_that_is_none() -> None:
    assert set(ids_with_rows()) - {""} <= set(IDS)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_the_named_test_exists(name: str) -> None:
    module, _, function = FUNCTIONS[name].partition(":")
    assert callable(getattr(import_module(module), function))
