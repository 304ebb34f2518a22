"""What the documentation names exists: symbols, keys of equations, linked files."""

from __future__ import annotations

import ast
import json
import re
from functools import cache
from pathlib import Path
from typing import get_args

import pytest
from pydantic import BaseModel

from owt_model.config import CaseConfig, parse_case
from owt_model.errors import InputError

ROOT = Path(__file__).parents[1]
PAGES = sorted([*(ROOT / "docs").glob("*.md"), ROOT / "README.md", ROOT / "examples" / "README.md"])


@cache
def identifiers() -> set[str]:
    """Every name that the code defines or takes: functions, arguments, fields, variables."""
    found: set[str] = set()
    for path in (ROOT / "src").glob("*/owt_*/**/*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                found.add(node.name)
            elif isinstance(node, ast.arg):
                found.add(node.arg)
            elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                found.add(node.id)
    return found


def is_case_key(name: str) -> bool:
    """Whether a dotted name leads through the configuration."""
    model: type[BaseModel] | None = CaseConfig
    for part in name.split("."):
        if model is None or part not in model.model_fields:
            return False
        kinds = (model.model_fields[part].annotation, *get_args(model.model_fields[part].annotation))
        model = next((k for k in kinds if isinstance(k, type) and issubclass(k, BaseModel)), None)
    return True


def exists(name: str) -> bool:
    return is_case_key(name) if "." in name else name in identifiers()


def test_every_symbol_has_its_name_in_the_code() -> None:
    page = (ROOT / "docs" / "symbols.md").read_text(encoding="utf-8")
    rows = [line.split("|") for line in page.splitlines() if re.match(r"\| (?!symbol)", line)]
    names = [name for row in rows for name in re.findall(r"`([^`]+)`", row[3])]
    assert len(names) > 60
    assert [name for name in names if not exists(name)] == []


@pytest.mark.parametrize("name", ["no_such_name", "morison.cx", "morison.cd.z", "sea_state_m"])
def test_a_name_that_is_not_there_would_be_noticed(name: str) -> None:
    assert not exists(name)


def test_keys_of_equations_are_defined_once_and_resolve() -> None:
    theory = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8")
    defined = re.findall(r"\((?:corrected [\d.]+, )?(W\d+)\)$", theory, re.MULTILINE)
    assert defined == [f"W{i}" for i in range(1, len(defined) + 1)]
    for path in [*PAGES, *(ROOT / "src").glob("*/owt_*/**/*.py")]:
        text = path.read_text(encoding="utf-8")
        used = re.findall(r"\b(W[1-9]\d?)\b", text) if path in PAGES else re.findall(r"eq\. (W\d+)", text)
        assert set(used) <= set(defined), path


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_linked_files_are_there(path: Path) -> None:
    targets = re.findall(r"\]\(([^)#\s]+)", path.read_text(encoding="utf-8"))
    local = [target for target in targets if "://" not in target]
    assert [target for target in local if not (path.parent / target).exists()] == []


def test_case_lines_of_the_readme_are_valid() -> None:
    """Every line of the README that shows part of a case is one that the configuration takes."""
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    lines = re.findall(r'^    ("\w+": \{.*\})', page, re.MULTILINE)
    assert len(lines) >= 9
    for line in lines:
        parse_case(json.loads("{" + line + "}"))
    with pytest.raises(InputError):
        parse_case(json.loads('{"sea_state": {"hs": 6}}'))
