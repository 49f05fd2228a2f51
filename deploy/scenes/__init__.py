"""What each mission adds to the picture of a run, one file per mission."""
