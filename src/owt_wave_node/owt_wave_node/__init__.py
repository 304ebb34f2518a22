"""Waves and wave loads: spectrum, kinematics, Morison forces, nodal loads."""
