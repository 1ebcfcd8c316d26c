"""The report of a budget: its verdict and texts in one plain dict, then terminal, page, figures and Markdown."""
