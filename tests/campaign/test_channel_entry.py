"""The channels of a record. Truth: the campaign contract, and a line with place and remedy for each fault."""

import pytest

from mechid.campaign import load_campaign

NAME = 'name = "full_46"'
TORQUE = '{ quantity = "torque", column = "Mz" }'

REFUSED = {
    "channels of a wrong type": (
        NAME,
        f'{NAME}\nchannels = "Mz"',
        f'record[0].channels: found "Mz"; write a list of tables, as [{TORQUE}]',
    ),
    "no channels": (
        NAME,
        f"{NAME}\nchannels = []",
        f"record[0].channels: found []; write a list of tables, as [{TORQUE}]",
    ),
    "unknown quantity": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torqe", column = "Mz" }}]',
        'record[0].channels[0].quantity: found "torqe"; did you mean "torque"?',
    ),
    "time as a channel": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "time", column = "t" }}]',
        'record[0].channels[0].quantity: found "time"; write one of "torque", ',
    ),
    "no quantity": (
        NAME,
        f'{NAME}\nchannels = [{{ column = "Mz" }}]',
        'record[0].channels[0].quantity: missing; write what it is, as quantity = "torque"',
    ),
    "no column": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torque" }}]',
        f"record[0].channels[0].column: missing; write {TORQUE}",
    ),
    "column of a wrong type": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torque", column = -1 }}]',
        "record[0].channels[0].column: found -1; write the column's name or path, or its index from 0",
    ),
    "unit of something else": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torque", column = "Mz", unit = "V" }}]',
        'record[0].channels[0].unit: unit "V" does not measure torque; expected N*m or a multiple of it',
    ),
    "gain of zero": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torque", column = "Mz", gain = 0.0 }}]',
        "record[0].channels[0].gain: found 0; it would erase the channel, write -1.0 to reverse its sign",
    ),
    "gain that is not finite": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torque", column = "Mz", gain = inf }}]',
        "record[0].channels[0].gain: found inf; write a finite number",
    ),
    "unknown role": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torque", column = "Mz", role = "outptu" }}]',
        'record[0].channels[0].role: found "outptu"; did you mean "output"?',
    ),
    "input": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torque", column = "Mz", role = "input" }}]',
        "record[0].channels: only inputs; add a channel that the model has to match",
    ),
    "input that drives nothing": (
        NAME,
        f'{NAME}\nchannels = [{TORQUE}, {{ quantity = "force", column = "F", role = "input" }}]',
        'record[0].command.stepping: the record is driven by its channels of role = "input" (force); leave one out',
    ),
    "between without input": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "torque", column = "Mz", between = "held" }}]',
        "record[0].channels[0].between: applies to inputs only",
    ),
    "no torque": (
        NAME,
        f'{NAME}\nchannels = [{{ quantity = "force", column = "Fz" }}]',
        "record[0].channels: force: the mechanism gives torque, rotor_angle, rotor_rate, output_angle, ",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_wrong_entry_says_where_what_and_the_remedy(name, changed, refused):
    old, new, message = REFUSED[name]
    path = changed("campaign.toml", old, new)
    refused(f"campaign.toml: {message}", load_campaign, path)
