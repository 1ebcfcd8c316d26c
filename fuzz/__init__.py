"""Inputs made and changed by a program: small builders write valid files, change fields of them, and mechid reads them.

`python -m fuzz` runs it; docs/reliability.md says what is asked of mechid and what was found.
"""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))  # its builders of mechanisms
