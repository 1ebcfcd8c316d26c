"""A record read from a file as a campaign asks for it, and the one line of a file that is refused."""

import pytest

from mechid.errors import RecordError
from mechid.records import ChannelSpec, RecordSpec, read_record


def torque(column, **more):
    return ChannelSpec(quantity="torque", column=column, **more)


def read(path, *channels, **asked):
    return read_record(path, RecordSpec(name="run", path=path.name, channels=channels, **asked))


def refused(path, *channels, **asked):
    with pytest.raises(RecordError) as caught:
        read(path, *channels, **asked)
    message = str(caught.value)
    assert message.startswith(path.name)
    assert "\n" not in message
    return message
