"""Pulses of a driver: how long it feeds its phases after each step, and what remains until the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.command.excitation import Excitation
from mechid.errors import UsageError

NEAR = 1e-9
"""Share of a pulse by which its end may miss the next step through rounding."""


@dataclass(frozen=True)
class Pulse:
    """Pulse of a driver after each step.

    Parameters
    ----------
    on_s : float
        Duration of the pulse in s of the driver's clock, above 0.
    hold : float
        Share of the voltage, or of the current of a current drive, between pulses, 0 to 1. With 0 and a mechanism whose
        phases are open then, the input 0 stands for an open phase.
    """

    on_s: float
    hold: float = 0.0

    def cut(self, whole: Excitation, last_s: float, duration_s: float) -> Excitation:
        """Return an excitation that falls to its share at the end of each pulse.

        A step within a pulse begins a new one.

        Parameters
        ----------
        whole : Excitation
            Step edges, each with the values that the driver holds without pulses.
        last_s : float
            Instant of the last step before time 0, in s; minus infinity if there is none.
        duration_s : float
            Later ends of pulses are left out.

        Examples
        --------
        >>> steps = Excitation(np.array([1.0]), np.array([0.1, 0.2]), np.array([[2.0], [4.0]]), ("e",))
        >>> cut = Pulse(0.04, 0.5).cut(steps, -np.inf, 0.23)
        >>> cut.initial, cut.times, cut.values.ravel()
        (array([0.5]), array([0.1 , 0.14, 0.2 ]), array([2., 1., 4.]))
        """
        starts = np.concatenate([[last_s], whole.times])
        values = np.concatenate([whole.initial[None], whole.values])
        ends = starts + self.on_s
        followed = np.append(whole.times, np.inf)
        kept = (ends > 0.0) & (ends < followed - NEAR * self.on_s) & (ends <= duration_s)
        times = np.concatenate([whole.times, ends[kept]])
        order = np.argsort(times, kind="stable")
        fallen = self._fallen(values[kept])
        return Excitation(
            initial=whole.initial if ends[0] > 0.0 else self._fallen(whole.initial),
            times=times[order],
            values=np.ascontiguousarray(np.concatenate([whole.values, fallen])[order]),
            inputs=whole.inputs,
        )

    def _fallen(self, values: FloatArray) -> FloatArray:
        # Adding 0.0 turns negative zeros into zeros.
        return self.hold * values + 0.0

    def check(self, fastest: float) -> None:
        """Refuse a largest rate in steps of the driver per s at which the next step comes before the pulse ends.

        Raises
        ------
        UsageError
            A step is shorter than the pulse.
        """
        if fastest * self.on_s > 1.0 + NEAR:
            raise UsageError(
                f"rate: a step every {1.0 / fastest:.6g} s is shorter than stepper.pulses.on_s = {self.on_s:.6g} s; "
                "write a shorter pulse or a slower rate"
            )
