"""A page on which a joint can be explored; it computes in the browser."""
