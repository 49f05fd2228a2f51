"""One algorithm, one file, one class. To add yours, see the README."""
