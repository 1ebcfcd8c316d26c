"""What is drawn for a field: ordinary values, values at the edge of what there is, and values of another type."""

import datetime
import math
import random
import string
from typing import Any

EDGES = (
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    2.0,
    1e-320,
    5e-324,
    2.2e-308,
    1e-30,
    1e-12,
    1e-9,
    1e9,
    1e12,
    1e30,
    1e100,
    1e154,
    1e300,
    1.7e308,
    -1.7e308,
    math.inf,
    -math.inf,
    math.nan,
    360.0,
    -180.0,
    1.0000000001,
    0.1 + 0.2,
    1e16,
)
WHOLE_EDGES = (
    0,
    1,
    -1,
    2,
    3,
    7,
    16,
    17,
    64,
    65,
    100,
    255,
    256,
    65535,
    2**31 - 1,
    2**31,
    -(2**31),
    2**32,
    2**53,
    2**53 + 1,
    2**63 - 1,
    -(2**63),
)
WORDS = (
    "",
    " ",
    "torque",
    "time",
    "t",
    "time_s",
    "Mz",
    "Mz [Nm]",
    "iA_mA",
    "x" * 300,
    "ü°Ω",
    "\u202eabc",
    "a/b",
    "../up",
    "/abs",
    "a\\b",
    "a.b",
    "nan",
    "inf",
    "1e5",
    "0",
    "-1",
    "true",
    "None",
    "N*m",
    "mN·m",
    "kg m^2",
    "m**-99999",
    "9**9**9",
    "1/0",
    "%s%n",
    "{0}",
    "<b>",
    "a,b",
    "a;b",
    'say "x"',
    "tab\there",
    "two\nlines",
    "nul\0nul",
    "\ufeffx",
    "😀",
    "e" * 70,
    "__import__('os')",
    "None",
    "DROP",
    "full",
    "half",
    "micro",
    "output",
    "input",
    "rad",
    "deg",
    "s",
    "ms",
    "Hz",
    "CON",
    "x.csv",
    "~",
    "*",
    "[1]",
)


class Draw(random.Random):
    """A generator of one input: the same for the same kind and number."""

    def __init__(self, kind: str, number: int) -> None:
        super().__init__(f"{kind} {number}")

    def chance(self, p: float) -> bool:
        """Return True in a share `p` of draws."""
        return self.random() < p

    def number(self) -> float:
        """Return a number, one in three of them at an edge."""
        if self.chance(0.35):
            return self.choice(EDGES)
        if self.chance(0.4):
            return round(self.uniform(-10.0, 100.0), self.randrange(4))
        return self.uniform(-1.0, 1.0) * 10.0 ** self.randint(-12, 12)

    def whole(self) -> int:
        """Return a whole number that 64 bits hold."""
        return self.choice(WHOLE_EDGES) if self.chance(0.5) else self.randint(-5, 200)

    def text(self) -> str:
        """Return a text; letters of any alphabet, or a word that means something somewhere."""
        if self.chance(0.8):
            return self.choice(WORDS)
        letters = string.printable if self.chance(0.5) else "".join(map(chr, range(0xA0, 0x250)))
        return "".join(self.choices(letters, k=self.randint(1, 40)))

    def near(self, value: float) -> float:
        """Return a number that is a little, or by a power of ten, another one."""
        how = self.choice((1.0 + 1e-15, 1.001, 0.5, 2.0, 10.0, 0.1, -1.0, 1e3, 1e-3, 1e6))
        return value * how if value else self.choice((1e-9, 1e-3, -1.0, 1.0))

    def anything(self, depth: int = 0) -> Any:
        """Return a value that TOML or JSON can hold, of any type."""
        kind = self.randrange(9 if depth < 3 else 5)
        if kind == 0:
            return self.number()
        if kind == 1:
            return self.whole()
        if kind in (2, 3):
            return self.text()
        if kind == 4:
            return self.choice((True, False))
        if kind == 5:
            return [self.anything(depth + 1) for _ in range(self.randrange(4))]
        if kind == 6:
            return {self.text() or "key": self.anything(depth + 1) for _ in range(self.randrange(3))}
        if kind == 7:
            return [self.number() for _ in range(self.randrange(5))]
        return datetime.date(2026, 3, self.randint(1, 28))
