"""A page on which a joint can be explored; the browser computes."""
