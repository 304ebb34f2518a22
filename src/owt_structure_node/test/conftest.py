"""Small structures with closed-form answers, and the numbers of other codes."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from owt_model.config import parse_case
from owt_model.contracts import LoadBasis, LoadBlock
from owt_model.mesh import Mesh, build_mesh
from owt_model.structure import Structure, load_structure, parse_structure
from owt_structure_node.core.assembly import assemble

DATA = Path(__file__).parents[3] / "test" / "data" / "structure"

E, G, RHO = 2.1e11, 8.0769e10, 7850.0
DIAMETER, THICKNESS = 1.2, 0.05
CLAMPED = [True] * 6


def cantilever(
    *, length=20.0, direction=(0.0, 0.0, 1.0), elements=4, beam="euler-bernoulli", **more
) -> Structure:
    """One clamped tube from the origin of z = -50 m; its free end is the transition piece."""
    unit = np.array(direction) / np.linalg.norm(direction)
    base = np.array([0.0, 0.0, -50.0])
    tip = base + length * unit
    data = {
        "name": "cantilever",
        "beam": beam,
        "elements_per_member": elements,
        "mudline_z_m": -50.0,
        "sections": {
            "tube": {
                "diameter_m": DIAMETER,
                "thickness_m": THICKNESS,
                "youngs_modulus_pa": E,
                "shear_modulus_pa": G,
                "density_kg_m3": RHO,
            }
        },
        "joints": {"A": base.tolist(), "B": tip.tolist()},
        "members": {"M": {"joints": ["A", "B"], "section": "tube"}},
        "supports": {"A": CLAMPED},
        "interface": {"joints": ["B"], "reference_m": tip.tolist()},
    }
    return parse_structure(data | more, source="cantilever")


def frame(**more) -> Structure:
    """Four inclined legs with braces, two levels, tied at the top: small, and nothing in it symmetric."""
    corners = {"1": (6.0, 5.0), "2": (-6.0, 5.5), "3": (-5.5, -6.0), "4": (6.5, -5.0)}
    joints = {}
    for level, (z, size) in {"a": (-30.0, 1.0), "b": (-12.0, 0.8), "c": (6.0, 0.6)}.items():
        joints |= {f"{level}{n}": [x * size, y * size, z] for n, (x, y) in corners.items()}
    members = {}
    for lower, upper in (("a", "b"), ("b", "c")):
        for n in corners:
            after = str(int(n) % 4 + 1)
            members[f"leg{lower}{n}"] = {"joints": [lower + n, upper + n], "section": "leg", "flooded": True}
            members[f"brace{lower}{n}"] = {"joints": [lower + n, upper + after], "section": "brace"}
    tube = {"youngs_modulus_pa": E, "shear_modulus_pa": G, "density_kg_m3": RHO}
    data = {
        "name": "frame",
        "elements_per_member": 2,
        "mudline_z_m": -30.0,
        "sections": {
            "leg": tube | {"diameter_m": 1.2, "thickness_m": 0.04},
            "brace": tube | {"diameter_m": 0.6, "thickness_m": 0.02},
        },
        "joints": joints,
        "members": members,
        "supports": {f"a{n}": CLAMPED for n in corners},
        "interface": {"joints": [f"c{n}" for n in corners], "reference_m": [0.0, 0.0, 8.0]},
        "transition_piece": {"mass_kg": 2e5, "inertia_kg_m2": [1e6, 1e6, 2e6, 0.0, 0.0, 0.0]},
        "tower": tube
        | {
            "height_m": 40.0,
            "elements": 3,
            "diameter_base_m": 4.0,
            "diameter_top_m": 3.0,
            "thickness_base_m": 0.03,
            "thickness_mid_m": 0.025,
            "thickness_top_m": 0.02,
        },
        "rotor_nacelle": {"mass_kg": 1e5, "inertia_kg_m2": [1e6, 2e6, 1.5e6, 0.0, 0.0, 0.0]},
        "marine_growth": {"thickness_m": 0.1, "density_kg_m3": 1100.0, "z_bottom_m": -20.0, "z_top_m": -2.0},
        "flooding": {"density_kg_m3": 1025.0},
        "added_mass": {"density_kg_m3": 1025.0},
    }
    return parse_structure(data | more, source="frame")


def block(
    mesh: Mesh, nodal, *, node=None, element=None, fixed_end=None, sequence=0, start=0, dt=0.1, last=True
):
    """Build a load block, on all nodes and without fixed-end forces unless told otherwise."""
    nodal = np.ascontiguousarray(nodal, dtype=float)
    element = np.zeros(0, dtype=np.int64) if element is None else element
    return LoadBlock(
        sequence=sequence,
        start=start,
        dt=dt,
        last=last,
        model_hash=mesh.structure.content_hash,
        node=np.arange(mesh.n_nodes) if node is None else node,
        element=element,
        nodal=nodal,
        fixed_end=np.zeros((len(nodal), len(element), 12)) if fixed_end is None else fixed_end,
    )


def load_basis(mesh: Mesh, vectors, *, node=None, model_hash=None) -> LoadBasis:
    """Build a load basis of given vectors [vector, node, 6], on all nodes unless told otherwise."""
    vectors = np.ascontiguousarray(vectors, dtype=float)
    return LoadBasis(
        model_hash=mesh.structure.content_hash if model_hash is None else model_hash,
        node=np.arange(mesh.n_nodes) if node is None else node,
        vectors=vectors,
        singular_values=np.ones(len(vectors)),
        total_variance=float(len(vectors)),
        mean=np.zeros(vectors.shape[1:]),
        snapshots=100,
    )


@cache
def shipped(name: str):
    """Mesh and assembly of a shipped structure, built once."""
    mesh = build_mesh(load_structure(name))
    return SimpleNamespace(mesh=mesh, assembly=assemble(mesh))


@pytest.fixture(scope="session")
def models() -> SimpleNamespace:
    """Builders of test structures and blocks."""
    return SimpleNamespace(
        cantilever=cantilever,
        frame=frame,
        block=block,
        load_basis=load_basis,
        shipped=shipped,
        parse_case=parse_case,
        E=E,
        G=G,
        rho=RHO,
        diameter=DIAMETER,
        thickness=THICKNESS,
    )


@pytest.fixture(scope="session")
def reference():
    """Reader of ``test/data/structure/NAME.json``."""

    @cache
    def read(name: str):
        return json.loads((DATA / f"{name}.json").read_text(encoding="utf-8"))

    return read
