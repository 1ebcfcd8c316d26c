"""Output-error problem: measured channels and model outputs, weighted, in search coordinates, reduced to triangles."""
