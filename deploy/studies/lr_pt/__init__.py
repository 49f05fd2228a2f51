"""The comparison of LR-PT with others by Kobayashi et al. 2025, run again: plan, trials, claims, report."""
