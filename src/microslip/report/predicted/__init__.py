"""Prediction of a joint: numbers, document, figures."""
