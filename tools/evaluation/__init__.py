"""The evaluator: readers of predictions and truth, protocols, and reports."""
