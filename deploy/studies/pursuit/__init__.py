"""Pursuit-evasion without maps by Kolling and Carpin 2010, run again: plan, runs, statements, report."""
