"""The live picture of a running graph: markers of the structure, its stress and the sea around it."""
