"""Who may do what: the policy against the running graph, closed doors, and code that trusts no input."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
import rclpy
from rclpy.context import Context

from local_graph import NODES, SUCCESS, LocalGraph, short_case
from owt_bringup.graph import run_graph
from owt_bringup.security import BRINGUP, SERVER, Rights, enclave_arguments, policy_xml, rights
from owt_bringup.server import BringupNode
from owt_bringup.supervisor import Supervisor
from owt_model.errors import InputError, OwtError
from owt_ros.topics import POSTPROC, STRUCTURE, WAVE

ROOT = Path(__file__).parents[1]


# --- the policy ---------------------------------------------------------------------------------------


def test_the_policy_file_is_that_of_the_topics() -> None:
    text = (ROOT / "src" / "owt_bringup" / "config" / "policy.xml").read_text(encoding="utf-8")
    assert text == policy_xml(), "write it again with `python -m owt_bringup.security`"
    root = ElementTree.fromstring(text.encode())
    paths = [entry.get("path") for entry in root.iter("enclave")]
    assert sorted(map(str, paths)) == sorted(f"/owt/{name}" for name in rights())
    assert {entry.get("ns") for entry in root.iter("profile")} == {"/"}
    north = ElementTree.fromstring(policy_xml("north").encode())
    assert {entry.get("ns") for entry in north.iter("profile")} == {"/north"}
    with pytest.raises(InputError, match="is no ROS namespace"):
        policy_xml("no-namespace")


def in_full(names: Any, node: str) -> set[str]:
    """Relative and private names as the graph shows them in the root namespace."""
    private = {name: f"/{node}/{name[1:]}" for name in names if name.startswith("~")}
    return {private.get(name, name if name.startswith("/") else f"/{name}") for name in names}


def differences(watcher: Any, wanted: dict[str, Rights]) -> dict[str, Any]:
    """What nodes do beyond the policy, or the policy allows for nothing, by node and verb."""
    found: dict[str, Any] = {}
    for node, allowed in wanted.items():
        publish, reply = set(allowed.publish), set(allowed.reply)
        for action in allowed.execute:
            publish |= {f"{action}/_action/feedback", f"{action}/_action/status"}
            reply |= {f"{action}/_action/{name}" for name in ("send_goal", "cancel_goal", "get_result")}
        for verb, names, ask in (
            ("publish", publish, watcher.get_publisher_names_and_types_by_node),
            ("subscribe", allowed.subscribe, watcher.get_subscriber_names_and_types_by_node),
            ("reply", reply, watcher.get_service_names_and_types_by_node),
            ("request", allowed.request, watcher.get_client_names_and_types_by_node),
        ):
            try:
                actual = {name for name, _ in ask(node, "/")}
            except rclpy.node.NodeNameNonExistentError:
                actual = set()
            wrong = in_full(names, node) ^ actual
            if wrong:
                found[f"{node} {verb}"] = sorted(wrong)
    return found


@pytest.mark.graph
def test_the_policy_is_what_the_nodes_do(domain: int, tmp_path: Path) -> None:
    """Every publisher, subscription, service and client of every node, with a load at the tower top."""
    case, context = short_case(wind={"topic": {}}, live={"place_m": [0.0, 0.0]}), Context()
    overrides = {kind.ROLE: {"lease_s": 60.0} for kind in NODES}
    names: dict[str, Any] = dict.fromkeys((WAVE, STRUCTURE, POSTPROC))
    with LocalGraph(domain, case, tmp_path / "bag", NODES, overrides) as graph:
        for node in graph.nodes.values():
            assert node.trigger_configure() == SUCCESS
        rclpy.init(context=context, domain_id=domain)
        server = BringupNode(context=context, use_global_arguments=False)
        try:
            with Supervisor(domain, names, lambda: None):
                for _ in range(100):
                    graph.spin_for(0.1)
                    if not (found := differences(graph.watcher, rights())):
                        break
                assert found == {}
                wrong = {**rights(), WAVE: Rights(publish=rights()[WAVE].publish)}  # negative control
                assert f"{WAVE} subscribe" in differences(graph.watcher, wrong)
        finally:
            server.close()
            server.destroy_node()
            rclpy.shutdown(context=context)
            del server, context
    assert set(rights()) == {*names, BRINGUP, SERVER}


def test_enclaves_are_named_only_where_security_is_on() -> None:
    assert enclave_arguments(WAVE, {}) == []
    assert enclave_arguments(WAVE, {"ROS_SECURITY_ENABLE": "false"}) == []
    assert enclave_arguments(WAVE, {"ROS_SECURITY_ENABLE": "true"}) == ["--enclave", "/owt/wave_node"]


@pytest.mark.graph
def test_without_its_keys_nothing_of_a_secured_graph_starts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "keys" / "enclaves").mkdir(parents=True)
    monkeypatch.setenv("ROS_SECURITY_ENABLE", "true")
    monkeypatch.setenv("ROS_SECURITY_STRATEGY", "Enforce")
    monkeypatch.setenv("ROS_SECURITY_KEYSTORE", str(tmp_path / "keys"))
    with pytest.raises(OwtError, match=r"keys/enclaves/owt/\w+' does not exist") as error:
        run_graph(short_case(), tmp_path / "bag")
    assert "\n" not in str(error.value)
    assert not (tmp_path / "bag").exists()
    command = [sys.executable, "-m", "owt_bringup.cli", "serve"]
    found = subprocess.run(command, env=dict(os.environ), capture_output=True, text=True, timeout=60)
    assert found.returncode != 0
    assert "enclaves/owt/bringup_node' does not exist" in found.stderr
    assert found.stderr.splitlines()[-1].startswith("error: ")


# --- code that trusts no input ------------------------------------------------------------------------

MODULES = {"pickle", "cPickle", "_pickle", "marshal", "shelve", "dill", "cloudpickle", "joblib"}
BUILTINS = {"eval", "exec", "compile", "__import__"}
CALLS = {
    ("os", "system"), ("os", "popen"), ("yaml", "load"), ("yaml", "load_all"), ("yaml", "unsafe_load"),
    ("yaml", "full_load"), ("subprocess", "getoutput"), ("subprocess", "getstatusoutput"),
    ("pandas", "read_pickle"), ("pd", "read_pickle"),
}  # fmt: skip


def name_of(node: ast.expr) -> tuple[str, ...]:
    """Dotted name of an expression, as parts."""
    if isinstance(node, ast.Attribute):
        return (*name_of(node.value), node.attr)
    return (node.id,) if isinstance(node, ast.Name) else ("",)


def imported_by(node: ast.AST) -> list[str]:
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        return [str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names)]
    return []


def safe_loaders(tree: ast.AST) -> set[str]:
    """Classes derived from yaml.SafeLoader."""
    classes = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    return {node.name for node in classes if ("yaml", "SafeLoader") in map(name_of, node.bases)}


def loads_safely(call: ast.Call, loaders: set[str]) -> bool:
    """Whether ``yaml.load`` is told to make nothing but plain data."""
    loader = next((keyword.value for keyword in call.keywords if keyword.arg == "Loader"), None)
    return isinstance(loader, ast.Name) and loader.id in loaders


def findings(source: str) -> list[str]:
    """What in `source` could run input as code, or hand it to a shell."""
    found: list[str] = []
    tree = ast.parse(source)
    loaders = safe_loaders(tree)
    for node in ast.walk(tree):
        names = imported_by(node)
        found += [name for name in names if name.split(".")[0] in MODULES or tuple(name.split(".")) in CALLS]
        if not isinstance(node, ast.Call):
            continue
        name = name_of(node.func)
        called = (len(name) == 1 and name[0] in BUILTINS) or name[-2:] in CALLS
        if called and not (name == ("yaml", "load") and loads_safely(node, loaders)):
            found.append(".".join(name))
        for keyword in node.keywords:
            off = isinstance(keyword.value, ast.Constant) and keyword.value.value is False
            if keyword.arg in ("shell", "allow_pickle") and not off:
                found.append(f"{'.'.join(name)}({keyword.arg})")
    return found


def test_no_input_is_run() -> None:
    sources = sorted((ROOT / "src").glob("*/owt_*/**/*.py")) + sorted((ROOT / "tools").glob("*.py"))
    assert len(sources) > 150
    found = {str(path.relative_to(ROOT)): findings(path.read_text(encoding="utf-8")) for path in sources}
    assert {path: what for path, what in found.items() if what} == {}


@pytest.mark.parametrize(
    "line",
    [
        "import pickle",
        "from pickle import loads",
        "import marshal as m",
        "import shelve",
        "eval(text)",
        "exec(text)",
        "os.system(text)",
        "from os import system",
        "os.popen(text)",
        "subprocess.run(text, shell=True)",
        "subprocess.Popen(text, shell=flag)",
        "subprocess.getoutput(text)",
        "yaml.load(text)",
        "yaml.load(text, Loader=yaml.Loader)",
        "class Unsafe(yaml.Loader): pass\nyaml.load(text, Loader=Unsafe)",
        "from yaml import load",
        "np.load(path, allow_pickle=True)",
    ],
)
def test_what_runs_input_would_be_noticed(line: str) -> None:
    assert findings(line)


@pytest.mark.parametrize(
    "line",
    [
        "yaml.safe_load(text)",
        "class Strict(yaml.SafeLoader): pass\nyaml.load(text, Loader=Strict)",
        "np.load(path)",
        "np.load(path, allow_pickle=False)",
        "subprocess.run([a], shell=False)",
        "re.compile(text)",
        "json.loads(text)",
    ],
)
def test_what_is_harmless_is_left_alone(line: str) -> None:
    assert findings(line) == []
