"""Files of others, read where a crash, a hang or an endless file costs nothing.

Texts are read by `mechid.reading.whole`: regular files alone, up to a size. Formats of others' libraries are read in a
process of its own, by `mechid.reading.process`; `mechid.reading.child` is what runs there. It imports little: it
starts fast.

Internal to mechid but for the names that docs/python.md lists.
"""
