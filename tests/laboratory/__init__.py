"""A laboratory that is not there: records made without the package, and what it makes of them."""
