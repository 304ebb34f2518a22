"""Data and configuration shared by all stages: structure, mesh, case and the contracts between them."""
