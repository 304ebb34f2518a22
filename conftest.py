"""Checks array shapes and types at run time in the model package and in every core, in tests only."""

from jaxtyping import install_import_hook

install_import_hook(
    ["owt_model", "owt_wave_node.core", "owt_structure_node.core", "owt_postproc.core", "owt_viewer.core"],
    "beartype.beartype",
)
