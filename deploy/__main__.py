"""The command line: `picket`, or `python -m deploy`."""

import os
import sys

from deploy.command_line import parse
from deploy.launcher import LaunchError
from deploy.run_folder import RunError
from deploy.scenario_file import ScenarioError
from deploy.viewer import ViewerError
from world_server.journal import JournalError

OPERATOR_MISTAKE = 2


def main() -> None:
    """Parse, do, and turn an operator's mistake into one clear line and exit code 2."""
    sys.path.insert(0, os.getcwd())  # behaviours of third parties, here as in the node processes
    try:
        status = parse(sys.argv[1:])
    except (ScenarioError, RunError, JournalError, ViewerError) as error:
        print(f"picket: {error}", file=sys.stderr)
        status = OPERATOR_MISTAKE
    except LaunchError as error:
        print(f"picket: {error}", file=sys.stderr)
        status = 1
    except BrokenPipeError:
        status = 1
    sys.stdout.flush()
    os._exit(status)  # Zenoh's threads may outlive a closed session


if __name__ == "__main__":
    main()
