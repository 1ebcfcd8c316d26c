"""The explorer's sliders turned to the values that made its records."""

TRUTH = {"gear.stiffness": 913.47, "gear.damping": 0.39}


def at_truth(session):
    """Turn them, and return the session."""
    for name, value in TRUTH.items():
        session.turn(name, value)
    return session
