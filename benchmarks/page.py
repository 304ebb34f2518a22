"""``python -m benchmarks.page FILE.json``: put measured figures into the table of docs/performance.md."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from benchmarks.measure import ROOT

PAGE = ROOT / "docs" / "performance.md"
BEGIN, END = "<!-- figures -->", "<!-- end of figures -->"


def _figure(seconds: float) -> str:
    return f"{seconds * 1e3:.3g} ms" if seconds < 0.1 else f"{seconds:.3g} s"


def table(result: dict[str, Any]) -> str:
    """Markdown of the figures of one run."""
    lines = [
        f"{result['machine']}; 1500 x 1500 matrix product: {_figure(result['matmul_1500_s'])}.",
        "",
        "| what | wall | CPU | beside |",
        "|---|---|---|---|",
    ]
    for row in result["rows"]:
        what = row["what"].replace("  ", "&nbsp;&nbsp;", 1) if row["what"].startswith("  ") else row["what"]
        if "value" in row:
            lines.append(f"| {what} | {row['value']:.3g} {row['unit']} | | |")
            continue
        beside = [
            f"{name}: {_figure(s)} ({s / row['wall_s']:.3g} x)" for name, s in row.get("beside_s", {}).items()
        ]
        beside += [
            f"quoted, not measured here: {name}: {_figure(s)} ({s / row['cpu_s']:.3g} x our CPU)"
            for name, s in row.get("quoted_s", {}).items()
        ]
        if "memory_mib" in row:
            beside.append(f"peak memory {row['memory_mib']:.0f} MiB")
        lines.append(f"| {what} | {_figure(row['wall_s'])} | {_figure(row['cpu_s'])} | {'; '.join(beside)} |")
    return "\n".join(lines)


def main() -> int:
    """Rewrite the table."""
    result = json.loads(Path(sys.argv[1]).read_text())
    before, rest = PAGE.read_text().split(BEGIN)
    after = rest.split(END)[1]
    PAGE.write_text(f"{before}{BEGIN}\n{table(result)}\n{END}{after}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
