"""Structural response: beam elements, reduction, time integration, stresses, energies."""
