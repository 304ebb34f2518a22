"""Waves and wave loads: pure functions of a case and a mesh."""
