"""Data and configuration shared by all stages: structure, mesh, case and the contracts between them."""

__version__ = "0.1.0"
