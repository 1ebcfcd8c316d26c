"""Time histories: simulations of the records' commands at the estimated values."""

from __future__ import annotations

from mechid.campaign.trajectory_file import refuse_incomplete
from mechid.exports.handover import Trial
from mechid.exports.tables.table import Table, numbers
from mechid.plant.flight import keeps_stand
from mechid.plant.mechanism import Mechanism
from mechid.simulation.accuracy import simulate_accurately
from mechid.simulation.simulator import Simulator
from mechid.units import SI_UNIT

PREFIX = "history_"
MEASURED = "as the record's channel has it, with housing and test stand, offset and drift left away"
ON_BASE = "torque on a held base, without what only the test stand has"


AT_TRANSDUCER = "torque as the transducer shows it, with the test stand"


def simulate_history(bench: Mechanism, lined: Mechanism, lanes: int, trial: Trial) -> Table:
    """Simulate the command of a record, on the time base of the record.

    Parameters
    ----------
    bench : Mechanism
        Mechanism as identified, with the measured channels as outputs.
    lined : Mechanism
        The same mechanism on a held base (`plant.flight.with_line_filter`), with or without its test stand.
    lanes : int
        Number of derivatives in the kernel of `lined`; the kernel of the lines is reused.
    trial : Trial

    Raises
    ------
    FitError
        The mechanism diverged.
    """
    # Two simulations: the channels as measured on the bench, and the torque on the held base.
    seen = simulate_accurately(Simulator(bench.plant, trial.command, trial.base), bench.kernel_values())
    base = simulate_accurately(Simulator(lined.plant, trial.command, trial.base, capacity=lanes), lined.kernel_values())
    refuse_incomplete({trial.name: seen})
    refuse_incomplete({trial.name: base})
    columns = [
        numbers(
            f"{name}_{SI_UNIT[name].replace('*', '').replace('/', '_')}",
            SI_UNIT[name].replace("*", " "),
            MEASURED,
            values,
        )
        for name, values in seen.values.items()
    ]
    time = numbers("time_s", "s", "record time", seen.time)
    name, words = ("transducer_torque_Nm", AT_TRANSDUCER) if keeps_stand(lined) else ("base_torque_Nm", ON_BASE)
    return Table(f"{PREFIX}{trial.name}", (time, *columns, numbers(name, "N m", words, base.torque)), is_long=True)
