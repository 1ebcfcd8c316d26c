"""Locks of result folders: one run at a time holds a folder, and the leftovers of killed runs are removed.

Internal to mechid except for the names listed in docs/python.md.
"""

from mechid.locks.folder import hold_folder
from mechid.locks.leftovers import LOCK_NAME, sweep

__all__ = ["LOCK_NAME", "hold_folder", "sweep"]
