"""Many studies, records or scans, and what a restart goes by."""
