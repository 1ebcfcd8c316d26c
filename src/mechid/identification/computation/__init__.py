"""Long computations: their journal on disk, the map over tasks, and progress reports."""
