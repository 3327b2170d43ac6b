"""Laws of measured and drawn faces against independent boundary elements, for twenty kinds."""
