"""Which functions a user reaches: a static walk over names, from every stage, export, command and the Python door."""

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
Place = tuple[str, str]
"""Module and top-level name."""
OPEN_DOORS = ("orient.cli.", "orient.door.")
ENTRIES = (("orient.pipeline.", "compute"), ("orient.export.", "make"))


@cache
def _uses() -> dict[Place, set[Place]]:
    return {place: names for module, tree in _modules().items() for place, names in _definitions(module, tree).items()}


def all_names() -> frozenset[str]:
    """Dotted names of everything that is defined at the top of a module."""
    return frozenset(f"{module}.{name}" for module, name in _uses())


@cache
def reached_names() -> frozenset[str]:
    """Dotted names that a command, the `compute` of a stage or the `make` of an export uses."""
    uses = _uses()
    waiting = [place for place in uses if _is_door(place)]
    seen: set[Place] = set()
    while waiting:
        place = waiting.pop()
        if place not in seen:
            seen.add(place)
            waiting += [used for used in uses.get(place, set()) if used in uses]
    return frozenset(f"{module}.{name}" for module, name in seen)


def _is_door(place: Place) -> bool:
    module, name = place
    return module.startswith(OPEN_DOORS) or any(module.startswith(door) and name == entry for door, entry in ENTRIES)


@cache
def _modules() -> dict[str, ast.Module]:
    files = sorted((ROOT / "orient").rglob("*.py"))
    return {
        ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): ast.parse(
            file.read_text("utf-8")
        )
        for file in files
    }


def _definitions(module: str, tree: ast.Module) -> dict[Place, set[Place]]:
    """Every top-level name with what it uses: names of its own module, and imported ones wherever they are imported."""
    imported = _imports(tree)
    own = {name for node in tree.body for name in _names_of(node)}
    found: dict[Place, set[Place]] = {}
    for node in tree.body:
        used = _used(node, module, own, imported)
        for name in _names_of(node):
            found.setdefault((module, name), set()).update(used)
    return found


def _imports(tree: ast.Module) -> dict[str, Place]:
    """Local name -> module and name; an imported module has the name ''."""
    places: dict[str, Place] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("orient"):
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                place = (whole, "") if whole in _modules() else (str(node.module), alias.name)
                places[alias.asname or alias.name] = place
    return places


def _names_of(node: ast.stmt) -> list[str]:
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return [node.name]
    if isinstance(node, ast.Assign):
        return [name.id for target in node.targets for name in ast.walk(target) if isinstance(name, ast.Name)]
    if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
        return [node.target.id]
    return []


def _used(node: ast.stmt, module: str, own: set[str], imported: dict[str, Place]) -> set[Place]:
    used: set[Place] = set()
    for part in ast.walk(node):
        if isinstance(part, ast.Attribute) and isinstance(part.value, ast.Name):
            place = imported.get(part.value.id)
            if place and not place[1]:
                used.add((place[0], part.attr))
        if isinstance(part, ast.Name):
            if part.id in imported and imported[part.id][1]:
                used.add(imported[part.id])
            elif part.id in own:
                used.add((module, part.id))
    return used
