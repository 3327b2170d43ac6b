"""A virtual laboratory: records made without the package, and what it makes of them."""
