"""The time loop of a batch. Its modules are set as text behind the plant's part, as those of `kernel.loop` are.

Where a kernel's workspace has a number, that of a batch has one for each set, side by side: number `place` of set l is
w[place * SETS + l].
"""
