"""Terms beside the mechanism as written: put into a problem where records are not followed without them."""
