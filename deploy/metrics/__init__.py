"""Metrics: pure folds over the facts of a run, one file per mission."""
