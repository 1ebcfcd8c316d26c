"""Declaration of a record file. Truth: what was declared."""

from mechid.records import ChannelSpec, Role


def test_a_channel_is_written_as_it_was_declared():
    channel = ChannelSpec(quantity="torque", column=3, unit="mN*m", gain=-1.0, role=Role.OUTPUT)
    own = {"quantity": "torque", "column": "3", "unit": "mN*m", "gain": -1.0, "role": "output"}
    assert channel.to_dict() == own
    assert ChannelSpec(quantity="force_x", column="Fx", role=Role.SIDE).to_dict() == {
        "quantity": "force_x",
        "column": "Fx",
        "unit": None,
        "gain": None,
        "role": "side",
    }
