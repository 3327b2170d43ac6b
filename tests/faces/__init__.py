"""Laws of measured and drawn faces against independent boundary elements, for ten kinds."""
