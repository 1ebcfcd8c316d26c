"""What a finished fit is worth: its records predicted and judged, and hypotheses side by side.

`validate` judges every record of a fit, `compare` sets finished fits of the same records against each other.

Internal to mechid but for the names that docs/python.md lists.
"""

from mechid.analysis.comparison import Comparison, compare
from mechid.analysis.validation import ChannelValidation, RecordValidation, validate, with_validation

__all__ = ["ChannelValidation", "Comparison", "RecordValidation", "compare", "validate", "with_validation"]
