"""Exports of an identified mechanism as files for other tools, each verified against mechid.

Internal to mechid but for the names that docs/python.md lists.
"""
