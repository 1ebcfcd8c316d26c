"""The output-error problem: measured channels against the model, weighted, in search coordinates, as triangles."""
