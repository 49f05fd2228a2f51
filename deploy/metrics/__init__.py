"""Metrics: pure folds over the facts of a run, one for each mission: `feed` them facts, ask for a `summary`."""

from deploy.metrics.area import AreaMetrics
from deploy.metrics.line import LineMetrics

MISSIONS = {"area": AreaMetrics, "line": LineMetrics}
