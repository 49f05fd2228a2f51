"""Tests: one sentence each."""
