"""A batch: runs of one plant under one command with other values of the parameters, side by side in vector registers.

The text is that of the plant's kernel, each of whose numbers becomes `SETS` numbers that stand together.
"""
