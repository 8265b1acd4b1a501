"""The examples of docs/input.md are files that orient reads."""

import re
from pathlib import Path

from orient.intake.project_folder import FILES_OF_STAGE, ReadOptions, read_project

DOCUMENT = Path(__file__).parents[2] / "docs" / "input.md"
EXAMPLE = re.compile(r"```\w+\n# (\S+)\n(.*?)```", re.DOTALL)


def test_the_examples_are_a_project(tmp_path: Path) -> None:
    examples = {name: f"# {name}\n{text}" for name, text in EXAMPLE.findall(DOCUMENT.read_text(encoding="utf-8"))}
    assert set(examples) == {name for names in FILES_OF_STAGE.values() for name in names}
    for name, text in examples.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    inputs = {tables.stage: tables for tables in read_project(tmp_path, ReadOptions())}
    assert list(inputs) == list(FILES_OF_STAGE)
    counts = {name: len(rows) for tables in inputs.values() for name, rows in tables.tables.items()}
    assert counts == {
        "photo": 1,
        "distortion_coefficient": 5,
        "known_element": 4,
        "fiducial_mark": 4,
        "comparator_reading": 7,
        "map_sheet": 1,
        "graticule_cross": 5,
        "digitizer_reading": 3,
        "control_point": 2,
        "control_system": 1,
        "model_point": 2,
    }
    assert [event for tables in inputs.values() for event in tables.events] == []
