"""Isolated reading of third-party files: a crash, a hang or an endless file does not affect the caller.

`mechid.reading.whole` reads text files: regular files only, up to a maximum size. `mechid.reading.process` reads
formats that need third-party libraries in a separate process, whose main loop is `mechid.reading.child`. This package
imports little, so that the process starts fast.

Internal to mechid except for the names listed in docs/python.md.
"""
