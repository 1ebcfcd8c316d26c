"""Batches: runs of one plant and command with several parameter points in parallel, one per vector lane.

The text is that of the plant's kernel, with each number replaced by `SETS` adjacent numbers.
"""
