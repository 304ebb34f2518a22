"""The thesis' tables and figures, each beside the print: one module per study."""
