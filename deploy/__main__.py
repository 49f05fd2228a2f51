"""The command line: `picket`, or `python -m deploy`."""

import os
import sys

from deploy.command_line import parse
from deploy.launcher import LaunchError
from deploy.run_folder import RunError
from deploy.scenario_file import ScenarioError
from deploy.sweep import SweepError
from deploy.viewer import ViewerError
from world_server.journal import JournalError

OPERATOR_MISTAKE, INTERRUPTED = 2, 130


def main() -> None:
    """Do what the command line says, and end."""
    sys.path.insert(0, os.getcwd())  # behaviours of third parties, here as in the node processes
    status = carry_out(sys.argv[1:])
    sys.stdout.flush()
    os._exit(status)  # Zenoh's threads may outlive a closed session


def carry_out(arguments: list[str]) -> int:
    """Parse, do, and turn an operator's mistake into one clear line; returns the exit code."""
    try:
        return parse(arguments)
    except (ScenarioError, RunError, JournalError, ViewerError) as error:
        print(f"picket: {error}", file=sys.stderr)
        return OPERATOR_MISTAKE
    except (LaunchError, SweepError) as error:
        print(f"picket: {error}", file=sys.stderr)
        return 1
    except BrokenPipeError:
        return 1
    except KeyboardInterrupt:  # before or after a run, which has its own ways to end
        print("picket: interrupted", file=sys.stderr)
        return INTERRUPTED


if __name__ == "__main__":
    main()
