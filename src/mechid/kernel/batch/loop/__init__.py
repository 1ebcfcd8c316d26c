"""Time loop of a batch; its modules are appended as text to the plant-specific functions, as those of `kernel.loop`.

Where a kernel's workspace has one number, that of a batch has one for each set, side by side: number `place` of set l
is w[place * SETS + l].
"""
