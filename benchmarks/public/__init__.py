"""Public benchmark: ten campaigns, the package that scores submissions, and the entries of the table in the docs."""
