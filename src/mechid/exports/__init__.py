"""What others take over of an identified mechanism: files, each held against mechid before it counts as written.

Internal to mechid but for the names that docs/python.md lists.
"""
