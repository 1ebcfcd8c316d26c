"""What is believed: blocks, wiring as data, and the `Plant` and `Mechanism` made of them.

Internal to mechid but for the names that docs/python.md lists.
"""
