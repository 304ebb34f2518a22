"""A small invented run on the real mesh, as blocks and as a bag: no other stage is needed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from owt_model.config import CaseConfig, parse_case
from owt_model.contracts import (
    ElevationBlock,
    EnergyBlock,
    LoadBlock,
    ModalBlock,
    ReducedDescription,
    StressBlock,
)
from owt_model.frame import frame_of_mesh
from owt_model.mesh import Mesh, build_mesh
from owt_model.structure import load_structure
from owt_postproc.bag import BagWriter
from owt_postproc.core.hot_spots import build_hot_spots
from owt_postproc.core.stage import build_fatigue_model, final, initial_state, step
from owt_postproc.report_data import ReportCollector, mesh_geometry

HEAD = "std_msgs/Header header\nuint64 sequence\nfloat64 dt\nuint32 samples\nbool last\n"
LINE = "=" * 80
HEADER = (
    f"{LINE}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    f"{LINE}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
)
SCHEMAS = {
    "/owt/model": (
        "ModelDescription",
        "string model_name\nstring model_hash\nstring[] node_name\nfloat64[] node_position_m\n"
        "int32[] node_dof\nstring[] member_name\nuint32[] member_node\nfloat64[] member_diameter_m\n"
        "float64[] member_thickness_m\nuint32[] element_member\nuint32[] element_node\n",
    ),
    "/owt/sea_state": (
        "SeaState",
        "float64 hs_m\nfloat64 tp_s\nfloat64 gamma\nfloat64 direction_deg\nuint64 seed\nuint8 order\n"
        "string stretching\nfloat64 cutoff_rad_s\nfloat64 water_depth_m\nfloat64 duration_s\n",
    ),
    "/owt/reduced_model": (
        "ReducedModel",
        "string model_name\nstring model_hash\nstring reduction\nstring[] coordinate_name\n"
        "int32 tower_top_coordinate\nfloat64[] frequency_hz\nfloat64[] damping_ratio\nstring[] end_name\n",
    ),
    "/owt/surface_elevation": (
        "SurfaceElevation",
        HEAD + "float64[] gauge_m\nfloat64[] first_order\nfloat64[] total\n" + HEADER,
    ),
    "/owt/nodal_loads": (
        "NodalLoads",
        HEAD
        + "string model_hash\nuint32[] node\nuint32[] element\nfloat64[] nodal\nfloat64[] fixed_end\n"
        + HEADER,
    ),
    "/owt/modal_state": (
        "ModalState",
        HEAD + "float64[] displacement\nfloat64[] velocity\nfloat64[] acceleration\n" + HEADER,
    ),
    "/owt/member_stress": (
        "MemberStress",
        HEAD + "float64[] axial\nfloat64[] bending_y\nfloat64[] bending_z\nfloat64[] von_mises\n" + HEADER,
    ),
    "/owt/energy": (
        "Energy",
        HEAD
        + "float64[] potential\nfloat64[] kinetic\nfloat64[] potential_mode\nfloat64[] kinetic_mode\n"
        + "float64[] potential_substructure\nfloat64[] kinetic_substructure\n"
        + HEADER,
    ),
}
LATCHED = ("/owt/model", "/owt/sea_state", "/owt/reduced_model")
CONTRACT_TOPIC = {
    ElevationBlock: "/owt/surface_elevation",
    LoadBlock: "/owt/nodal_loads",
    ModalBlock: "/owt/modal_state",
    StressBlock: "/owt/member_stress",
    EnergyBlock: "/owt/energy",
}
RECEIVED_NS = 1_700_000_000_000_000_000
FIELD = {"gauge": "gauge_m"}


@dataclass(frozen=True)
class InventedRun:
    """Blocks of an invented response, and what a graph would latch before them."""

    case: CaseConfig
    mesh: Mesh
    reduced: ReducedDescription
    sea: dict
    blocks: list

    def of(self, kind: type) -> list:
        return [block for block in self.blocks if isinstance(block, kind)]


def noise(rng, t, channels, peak_hz, scale):
    """Smooth random series: 40 components round a peak and a little at three times its frequency."""
    f = peak_hz * np.concatenate([rng.uniform(0.7, 1.6, 30), rng.uniform(2.5, 3.5, 10)])
    amplitude = np.concatenate([np.full(30, 1.0), np.full(10, 0.25)])
    phase = rng.uniform(0, 2 * np.pi, (len(f), channels))
    waves = np.cos(2 * np.pi * f[None, :, None] * t[:, None, None] + phase[None])
    return np.ascontiguousarray(scale * np.einsum("f,tfc->tc", amplitude, waves) / 5.0)


def invented_run(duration: float = 40.0, block: int = 50) -> InventedRun:
    case = parse_case(
        {
            "time": {"dt_s": 0.1, "n": round(duration / 0.1)},
            "stream": {"block": block},
            "fatigue": {"scf": 2.0},
        }
    )
    mesh = build_mesh(load_structure("oc4"))
    ends, n = len(mesh.end_name), case.time.n
    rng = np.random.default_rng(7)
    t, s = case.time.dt_s * np.arange(n), case.structure.dt_s * np.arange(5 * (n - 1) + 1)
    strength = rng.lognormal(0.0, 0.6, ends)
    axial, bending_y, bending_z = (noise(rng, s, ends, 0.32, 4e6) * strength for _ in range(3))
    eta1, modal = noise(rng, t, 1, 0.106, 2.5), noise(rng, s, 12, 0.32, 0.05)
    nodal = np.zeros((n, 20, 6))
    nodal[:, :, :3] = noise(rng, t, 60, 0.106, 2e4).reshape(n, 20, 3)
    energy = noise(rng, s, 4, 0.32, 100.0) ** 2
    frequency = np.array([0.315, 0.317, 1.19, 1.21, 2.96, 3.4, 4.1])
    reduced = ReducedDescription(
        "oc4", mesh.structure.content_hash, "CB10M10", tuple(f"q{i}" for i in range(12)), frequency,
        np.linspace(0.01, 0.03, 7), mesh.end_name, 6,
    )  # fmt: skip
    blocks, node = [], np.arange(20)
    for i, start in enumerate(range(0, n, block)):
        w = slice(start, start + block)
        r = slice(0 if i == 0 else 5 * (start - 1) + 1, 5 * (min(start + block, n) - 1) + 1)
        load_head = {"sequence": i, "start": start, "dt": 0.1, "last": start + block >= n}
        head = {**load_head, "start": r.start, "dt": 0.02}
        stress = [np.ascontiguousarray(x[r]) for x in (axial, bending_y, bending_z)]
        blocks += [
            ElevationBlock(
                **load_head, gauge=np.zeros((1, 2)), first_order=eta1[w], total=eta1[w] + 0.06 * eta1[w] ** 2
            ),
            LoadBlock(
                **load_head, model_hash="h", node=node, element=node[:4], nodal=nodal[w],
                fixed_end=np.zeros((len(eta1[w]), 4, 12)),
            ),
            ModalBlock(**head, displacement=modal[r], velocity=modal[r], acceleration=modal[r]),
            StressBlock(**head, axial=stress[0], bending_y=stress[1], bending_z=stress[2],
                        von_mises=np.abs(stress[0]) + np.hypot(*stress[1:])),
            EnergyBlock(**head, potential=energy[r, 0], kinetic=energy[r, 1], potential_mode=energy[r, :2],
                        kinetic_mode=energy[r, 2:], potential_substructure=energy[r, :2],
                        kinetic_substructure=energy[r, 2:]),
        ]  # fmt: skip
    sea = {
        "hs_m": 6.0, "tp_s": 9.45, "gamma": 1.3, "direction_deg": 210.0, "seed": 1, "order": 2,
        "stretching": "taylor", "cutoff_rad_s": 2.66, "water_depth_m": 50.0, "duration_s": duration,
    }  # fmt: skip
    return InventedRun(case, mesh, reduced, sea, blocks)


def typestore():
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.EMPTY)
    for name, text in SCHEMAS.values():
        types = get_types_from_msg(text, f"owt_msgs/msg/{name}")
        store.register({k: v for k, v in types.items() if k not in store.types})
    return store


def flat(value, dtype=np.float64):
    return np.ascontiguousarray(value, dtype=dtype).ravel()


def latched_messages(run: InventedRun, store) -> dict[str, bytes]:
    mesh, reduced = run.mesh, run.reduced
    owner = np.where(mesh.element_member < 0, 2**32 - 1, mesh.element_member)
    values = {
        "/owt/model": {
            "model_name": "oc4", "model_hash": "h", "node_name": list(mesh.node_name),
            "node_position_m": flat(mesh.node_position), "node_dof": flat(mesh.node_dof, np.int32),
            "member_name": list(mesh.member_name), "member_node": flat(mesh.member_node, np.uint32),
            "member_diameter_m": mesh.element_diameter[mesh.member_element[:, 0]],
            "member_thickness_m": mesh.element_thickness[mesh.member_element[:, 0]],
            "element_member": flat(owner, np.uint32), "element_node": flat(mesh.element_node, np.uint32),
        },
        "/owt/sea_state": run.sea,
        "/owt/reduced_model": {
            "model_name": "oc4", "model_hash": reduced.model_hash, "reduction": reduced.reduction,
            "coordinate_name": list(reduced.coordinate_name), "tower_top_coordinate": 6,
            "frequency_hz": reduced.frequency_hz, "damping_ratio": reduced.damping_ratio,
            "end_name": list(reduced.end_name),
        },
    }  # fmt: skip
    return {topic: pack(store, SCHEMAS[topic][0], value) for topic, value in values.items()}


def pack(store, name: str, values: dict) -> bytes:
    full = f"owt_msgs/msg/{name}"
    return bytes(store.serialize_cdr(store.types[full](**values), full))


def block_message(block, store) -> tuple[str, bytes]:
    topic = CONTRACT_TOPIC[type(block)]
    header, time = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    values = {
        "header": header(time(block.time_ns // 10**9, block.time_ns % 10**9), ""),
        "sequence": block.sequence, "dt": block.dt, "last": block.last,
    }  # fmt: skip
    for name, value in vars(block).items():
        if isinstance(value, np.ndarray):
            integer = np.issubdtype(value.dtype, np.integer)
            values[FIELD.get(name, name)] = flat(value, np.uint32 if integer else np.float64)
            if name in ("total", "nodal", "displacement", "axial", "potential"):
                values["samples"] = len(value)
        elif name == "model_hash":
            values[name] = value
    return topic, pack(store, SCHEMAS[topic][0], values)


def begin_bag(path: Path, run: InventedRun, store, **options) -> BagWriter:
    writer = BagWriter(path, **options)
    for topic, (name, text) in SCHEMAS.items():
        writer.add_topic(topic, f"owt_msgs/msg/{name}", text, latched=topic in LATCHED)
    writer.attach("case.json", "application/json", run.case.model_dump_json().encode())
    writer.add_metadata("versions", {"owt": "0.1.0", "numpy": np.__version__})
    for topic, data in latched_messages(run, store).items():
        writer.write(topic, data, log_time_ns=0, publish_time_ns=0)
    return writer


def write_bag(path: Path, run: InventedRun, **options) -> Path:
    store = typestore()
    with begin_bag(path, run, store, **options) as writer:
        for i, block in enumerate(run.blocks):
            topic, data = block_message(block, store)
            times = {"log_time_ns": RECEIVED_NS + 1_000_000 * i, "publish_time_ns": block.time_ns}
            writer.write(topic, data, **times, sequence=block.sequence)
    return path


@pytest.fixture(scope="session")
def run() -> InventedRun:
    """40 s of an invented response."""
    return invented_run()


@pytest.fixture(scope="session")
def report_data(run):
    """Report data as a run in process collects it."""
    model = build_fatigue_model(run.case, build_hot_spots(frame_of_mesh(run.mesh), run.case.fatigue))
    state, collector = initial_state(model), ReportCollector(run.reduced.tower_top_coordinate)
    for block in run.blocks:
        collector.add(block)
        if isinstance(block, StressBlock):
            state, _ = step(model, state, block)
    return collector.finish(
        case=run.case.model_dump(mode="json"),
        reduced=run.reduced,
        fatigue=final(model, state),
        geometry=mesh_geometry(run.mesh),
        sea_state=run.sea,
        versions={"owt": "0.1.0", "numpy": np.__version__},
    )


@pytest.fixture(scope="session")
def bag(run, tmp_path_factory) -> Path:
    """The invented run as a complete bag; read only."""
    return write_bag(tmp_path_factory.mktemp("bags") / "run", run)


@pytest.fixture(scope="session")
def recording() -> SimpleNamespace:
    """How to write bags of invented runs."""
    return SimpleNamespace(
        run=invented_run,
        begin=begin_bag,
        write=write_bag,
        store=typestore,
        message=block_message,
        schemas=SCHEMAS,
    )
