"""One document of a result, and its renderers: terminal, HTML, JSON, CSV, netCDF. No physics."""
