"""A long computation: its journal on disk, its map over tasks, what it tells of itself."""
