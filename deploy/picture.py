"""A picture of a run at one time: `python -m deploy.picture RUN out.png --at SECONDS`, without a display.

Needs a Vulkan driver; Mesa's software one will do (Debian: mesa-vulkan-drivers libvulkan1). Kept apart from
the dashboard because Rerun calls the interface it uses experimental; if that goes, only pictures go.
"""

import argparse
import os
import sys
import time
from pathlib import Path

from PIL import Image
from rerun.experimental import ViewerClient

from deploy.dashboard import record
from deploy.layout import TIMELINE
from deploy.viewer import Viewer, ViewerError, launch

TITLE_BAR = 36  # pixels of the window's own bar, which is empty without a window
COLOURS_OF_NOTHING = 500  # an empty layout with "Loading" in it has fewer colours than this
STABLE_WITHIN_S = 60.0


def save_picture(recording: Path, picture: Path, at_s: float, size: str = "1600x900") -> None:
    """Show `recording` at `at_s` in a viewer without a window, and save what it looks like.

    Raises ViewerError when there is no driver, or nothing is drawn in time.
    """
    log = recording.parent / "logs" / "viewer.log"
    options = ("--headless", "--window-size", size)
    viewer = launch("native", log, *options, WGPU_BACKEND="vulkan", RERUN_APP_ONLY="true")
    try:
        viewer.wait_until_open()
        _shoot(viewer, recording, picture, at_s)
    finally:
        viewer.process.kill()
    with Image.open(picture) as shot:
        shot.convert("RGB").crop((0, TITLE_BAR, *shot.size)).save(picture, optimize=True)


def _shoot(viewer: Viewer, recording: Path, picture: Path, at_s: float) -> None:
    """Take pictures until two in a row are equal and show something: chunks are loaded one after another."""
    client = ViewerClient.connect(viewer.url)
    client.open(str(recording.resolve()))
    client.set_time(TIMELINE, duration=at_s, play_state="paused")
    until, before = time.monotonic() + STABLE_WITHIN_S, None
    time.sleep(6.0)  # a notice that it runs without a window covers a corner until then
    while time.monotonic() < until:
        client.save_screenshot(str(picture.resolve()))
        with Image.open(picture) as shot:
            now = shot.convert("RGB")
        if now.tobytes() == before and len(now.getcolors(1 << 24)) > COLOURS_OF_NOTHING:
            return
        before = now.tobytes()
        time.sleep(0.5)
    raise ViewerError(f"nothing stable was drawn within {STABLE_WITHIN_S:.0f} s; {viewer.log} may say why")


def main() -> int:
    """Record the run folder and take the picture."""
    parser = argparse.ArgumentParser(description="Save a picture of a finished run.")
    parser.add_argument("run", type=Path, help="a run folder, or a recording")
    parser.add_argument("picture", type=Path, help="a .png file")
    parser.add_argument("--at", type=float, required=True, metavar="SECONDS", help="simulated time")
    given = parser.parse_args()
    recording = record(given.run) if given.run.is_dir() else given.run
    save_picture(recording, given.picture, given.at)
    return 0


if __name__ == "__main__":
    try:
        status = main()
    except ViewerError as error:
        print(error, file=sys.stderr)
        status = 3
    sys.stdout.flush()
    os._exit(status)
