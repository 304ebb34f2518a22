"""Launch and parameter files. `launch` is not on PyPI: here the launch file is only compiled and read."""

import ast
from pathlib import Path

import pytest
import yaml

from owt_bringup.arguments import LAUNCH_ARGUMENTS, default_parameters, parameter_overrides
from owt_model.config import CaseConfig
from owt_model.errors import InputError
from owt_ros.fields import case_values

PACKAGE = Path(__file__).parents[1]


@pytest.mark.parametrize("path", sorted((PACKAGE / "launch").glob("*.py")), ids=lambda path: path.name)
def test_launch_files_compile_and_import_what_exists(path: Path) -> None:
    import importlib

    tree = ast.parse(path.read_text(encoding="utf-8"))
    compile(tree, str(path), "exec")
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(("owt_", "lifecycle_msgs")):
            module = importlib.import_module(str(node.module))
            for alias in node.names:
                assert hasattr(module, alias.name), f"{node.module}.{alias.name}"
    assert any(isinstance(n, ast.FunctionDef) and n.name == "generate_launch_description" for n in tree.body)


def test_the_launch_file_names_only_declared_arguments() -> None:
    text = (PACKAGE / "launch" / "graph.launch.py").read_text(encoding="utf-8")
    used = {
        node.slice.value
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Subscript)
        and isinstance(node.value, ast.Name)
        and node.value.id == "given"
        and isinstance(node.slice, ast.Constant)
    }
    assert used == {"bag", "namespace", "overwrite", "parameters"}
    assert used <= {argument.name for argument in LAUNCH_ARGUMENTS}


def test_the_default_parameter_file_holds_the_defaults() -> None:
    text = (PACKAGE / "config" / "default.yaml").read_text(encoding="utf-8")
    assert text == default_parameters(), "write it again with `python -m owt_bringup.arguments`"
    parameters = yaml.safe_load(text)["/**"]["ros__parameters"]
    assert parameters["sea_state"]["hs_m"] == CaseConfig().sea_state.hs_m  # type: ignore[union-attr]
    assert set(parameters) == {name.split(".")[0] for name in case_values(CaseConfig())}


def test_launch_arguments_become_typed_parameters() -> None:
    given = {"hs": "4", "order": "1", "reduction": "CB20", "seed": "", "bag": "x"}
    assert parameter_overrides(given) == {
        "sea_state.hs_m": 4.0,
        "wave.order": 1,
        "structure.reduction": "CB20",
    }
    assert all(isinstance(v, float) for k, v in parameter_overrides(given).items() if k.endswith("hs_m"))
    with pytest.raises(InputError, match="order = 'two': must be a whole number"):
        parameter_overrides({"order": "two"})
    with pytest.raises(InputError, match="hs = 'high': must be a number"):
        parameter_overrides({"hs": "high"})
