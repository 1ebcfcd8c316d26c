"""A campaign as it was understood: the public function and what is shown of its result."""
