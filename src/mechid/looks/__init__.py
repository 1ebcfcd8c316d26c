"""A look at records before any model: the public function and what is shown of its result."""
