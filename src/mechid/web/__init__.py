"""Explorer: a local page for changing parameters by hand and following fits.

Internal to mechid but for the names that docs/python.md lists.
"""

from mechid.web.estimate import Estimate, estimate_of, read_estimated
from mechid.web.server import Explorer
from mechid.web.session import Source
from mechid.web.stored_diagnosis import read_diagnosed

__all__ = ["Estimate", "Explorer", "Source", "estimate_of", "read_diagnosed", "read_estimated"]
