"""Random mechanisms, their records, and how the identification of each is judged."""
