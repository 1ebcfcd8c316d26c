"""Export as uncertain linear models at holding, and as harmonic forcing at steady rates."""
