"""Generation and compilation of kernels: generated source, a compiled `Kernel`, and its slow reference twin.

Internal to mechid but for the names that docs/python.md lists.
"""
