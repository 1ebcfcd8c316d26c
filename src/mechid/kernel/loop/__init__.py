"""Time loop of every kernel, as text: `kernel.source` appends it to the plant-specific functions (`plant.pyi`).

These modules are never imported. They are modules so that the project's checkers see them; the names that they import
are defined above them in a kernel's text.
"""
