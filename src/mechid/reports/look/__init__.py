"""The report of a look at records before any model: one plain dict, then terminal, page, figures and CSV."""
