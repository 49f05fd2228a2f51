"""Metrics: pure folds over the facts of a run, one for each mission: `feed` it facts, ask its `summary`."""

from deploy.metrics.area import AreaMetrics
from deploy.metrics.clear import ClearMetrics
from deploy.metrics.line import LineMetrics

MISSIONS = {"area": AreaMetrics, "line": LineMetrics, "clear": ClearMetrics}
