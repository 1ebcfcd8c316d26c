"""The time loop of every kernel, as text: `kernel.source` sets it behind what it writes of a plant (`plant.pyi`).

No module of these is ever imported. They are modules so that the checkers of the project see them; what they import
stands above them in a kernel's text.
"""
