"""After warm_up no kernel compiles again: a first run does not wait."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

SRC = Path(__file__).parents[2]

SCRIPT = """
import json, sys
from owt_model.config import parse_case
from owt_model.mesh import build_mesh
from owt_model.structure import load_structure
from owt_wave_node.kernels import compressed, directional, fft, morison, sections, spectra, surface, transfer
from owt_wave_node.kernels import warm_up, wheeler

def signatures():
    return {
        f"{module.__name__}.{name}": [str(s) for s in kernel.signatures]
        for module in (compressed, directional, fft, morison, sections, spectra, surface, transfer, wheeler)
        for name, kernel in vars(module).items()
        if hasattr(kernel, "signatures")
    }

warm_up() if sys.argv[1] == "warm" else None
before = signatures()
from owt_wave_node.core.kinematics import wave_kinematics
from owt_wave_node.core.stage import build_wave_stage
mesh = build_mesh(load_structure("oc4"))
short = {"time": {"dt_s": 0.1, "n": 60}, "points_m": [[0, 0, -5], [1, 2, 1]]}
gaps = {"components": {"omega_rad_s": [1.04719755119659763, 2.09439510239319526, 4.18879020478639],
                       "amplitude_m": [0.1, 0.1, 0.1], "phase_rad": [0, 1, 2]}}
wheeler_case, growth = {"wave": {"order": 1, "stretching": "wheeler"}}, {"morison": {"marine_growth": True}}
options = {"distribution": "quadratic", "axial_cd": 0.1, "points": "gauss", "diffraction": "maccamy-fuchs"}
full = {"current": {"speed_m_s": 0.5}, "morison": options | {"hydrodynamic_damping": True, "end_cd": 1.0}}
crossing = {"components": gaps["components"] | {"direction_deg": [0, 40, 90]}}
for extra in ({}, gaps, wheeler_case, growth, full, crossing):
    case = parse_case(short | extra)
    wave_kinematics(case)
    build_wave_stage(case, mesh)
print(json.dumps([name for name, found in signatures().items() if found != before[name]]))
"""


def compiled_late(mode: str) -> list[str]:
    result = subprocess.run(
        [sys.executable, "-c", SCRIPT, mode],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"PYTHONPATH": f"{SRC / 'owt_model'}:{SRC / 'owt_wave_node'}"},
    )
    found: list[str] = json.loads(result.stdout)
    return found


def test_warm_up_covers_what_a_run_needs() -> None:
    assert compiled_late("warm") == []


def test_warm_up_would_notice_a_kernel_left_out() -> None:
    assert "owt_wave_node.kernels.surface.surface_loads" in compiled_late("cold")
