"""What a report says of where its numbers come from: the machine, the interpreter, the source."""

import os
import platform
from pathlib import Path

from deploy.process import commit


def describe() -> dict[str, str]:
    """Processor, how many of them, interpreter and commit, each in words."""
    return {
        "processor": _processor(),
        "processors to use": str(len(os.sched_getaffinity(0))),
        "system": f"{platform.system()} {platform.release()}",
        "Python": platform.python_version(),
        "commit": commit() or "unknown: no git here",
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
    except OSError:
        lines = []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, platform.machine())
