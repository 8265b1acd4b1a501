"""An empty project from its schema text is what the migrations build."""

from pathlib import Path

from orient.store.creation import fill_empty_file, format_of
from orient.store.format import current_format
from orient.store.project import create_project


def test_the_template_is_what_the_migrations_build(tmp_path: Path) -> None:
    form = current_format()
    built, written = tmp_path / "built.sqlite", tmp_path / "written.sqlite"
    built.touch()
    fill_empty_file(built, form.version, form.application_id)
    create_project(written)
    told = [format_of(path, form.version, form.application_id, form.head) for path in (built, written)]
    assert told[0] == told[1]
    heads = [path.read_bytes()[:100] for path in (built, written)]
    assert heads[0][60:72] == heads[1][60:72]  # user_version, incremental vacuum, application_id
