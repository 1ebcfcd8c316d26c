"""A plant becomes generated source, a compiled `Kernel`, and its slow twin.

Internal to mechid but for the names that docs/python.md lists.
"""
