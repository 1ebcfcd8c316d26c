"""Result folders held by one run at a time: a lock file says by whom, and what a killed run left is swept away.

Internal to mechid but for the names that docs/python.md lists.
"""

from mechid.holding.folder import hold_folder
from mechid.holding.leftovers import LOCK_NAME, sweep

__all__ = ["LOCK_NAME", "hold_folder", "sweep"]
