"""Interactive web page that computes a joint with JavaScript in the browser."""
