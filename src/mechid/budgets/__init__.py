"""From an identified mechanism to the line of sight: disturbance, coupling, pointing error indices, margins."""
