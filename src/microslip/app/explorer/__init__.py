"""Interactive page that computes a joint in the browser."""
