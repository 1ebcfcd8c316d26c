"""The report of a design: its texts and verdict, its tables, then terminal, Markdown, figures."""
