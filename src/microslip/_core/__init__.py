"""Common base of all packages: errors, units, checks, quadrature and the compiled kernel."""
