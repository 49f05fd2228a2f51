"""Where all floors meet: the command line, the launcher, the rehearsal, metrics and pictures."""
