"""Shows the flight's camera code a real V4L2 stack: vivid on the emulated board, honest and with every fault it can make."""
import argparse
import os
import sys

import board as rig
import images

PROGRAMS = (("ilp-camera-check", "ilp-camera-check"), ("inject", "board-inject"))
BOOT_S = 300
CAMERA = "/dev/video0"
INTERVAL_S = 0.7313  # of no simple ratio to any rate of the camera
WEBCAM, START_OF_EXPOSURE, END_OF_FRAME = 0, 1, 0

# Each fault once, with room to recover; vivid's own words.
FAULTS = [(8, 1, "Inject V4L2_BUF_FLAG_ERROR"), (12, 1, "Inject VIDIOC_QBUF Error"),
          (16, 1, "Inject Fatal Streaming Error"), (24, 1, "Inject VIDIOC_STREAMON Error"),
          (24.2, 1, "Inject Fatal Streaming Error"), (32, 1, "Inject VIDIOC_REQBUFS Error"),
          (32.2, 1, "Inject Fatal Streaming Error"), (40, 20, "Percentage of Dropped Buffers"),
          (52, 0, "Percentage of Dropped Buffers"), (56, 1, "Disconnect")]

SIZE, OTHER_SIZE = "640 480", "600 400"


class Check:
    """One boot: settings of the camera, commands to vivid before and during the run, and the expected console output."""

    def __init__(self, name, settings, seconds, stamps=START_OF_EXPOSURE, faults=(), size=SIZE, expect=(), never=()):
        self.name, self.expect, self.never = name, expect, never
        words = [(-2, stamps, "Timestamp Source")] + list(faults)
        controls = " ".join(f'{at} {value} "{control}"' for at, value, control in words)
        self.run = (f"with inject {CAMERA} {controls}\n"
                    f"run ilp-camera-check {CAMERA},input={WEBCAM},{settings} {size} {seconds} {INTERVAL_S}\n")
        self.seconds = seconds


GOOD = ("camera_graded a = 0,", "frame time minus wanted")
CHECKS = [
    Check("honest at 25 Hz", "format=GREY,rate=25", 60, expect=GOOD, never=("camera_fault", "frame_gap", "no frame")),
    Check("honest at 10 Hz in colour", "format=YUYV,rate=10", 30, expect=GOOD, never=("camera_fault", "frame_gap", "no frame")),
    Check("16 bits", "format=Y16,rate=25", 20, expect=GOOD),
    Check("stamps at the end of the frame, ahead of the clock", "format=GREY,rate=25", 30, END_OF_FRAME,
          expect=("camera: time stamps ahead of the clock", "camera_distrusted", "frame time minus wanted")),
    Check("two of five frames lost", "format=GREY,rate=25", 20,
          faults=[(-1, 40, "Percentage of Dropped Buffers")], expect=("camera: frames missing", "frame_gap")),
    Check("another size", "format=GREY,rate=25", 10, size=OTHER_SIZE, expect=("a = 60000400",)),
    Check("controls out of range", "format=GREY,rate=25,gain=1000,exposure_us=5000", 10,
          expect=("camera_control_limited", "camera_control_missing", "frame time minus wanted")),
    Check("every fault in turn", "format=GREY,rate=25", 75, faults=FAULTS,
          expect=("camera_frames_refused", "camera_fault", "camera_recovered", "frame_gap", "frame time minus wanted")),
]


def carry_out(check, base, folder):
    """Problems of one check; the console's lines from the program on are printed."""
    os.makedirs(folder)
    booted = images.with_flight(base, {"run": check.run.encode()}, os.path.join(folder, "initramfs.cpio"), PROGRAMS)
    # On this board time is the number of instructions: what it says depends on no load of the host.
    with rig.Board(booted, os.path.join(folder, "console.log"), deterministic=True) as board:
        board.wait_for("^board: .* ready$", BOOT_S)
        board.wait_until_off(check.seconds + BOOT_S)
        said = [text for _, text in board.console]
    begin = next((i for i, text in enumerate(said) if "starts ilp-camera-check" in text), 0)
    print(f"== {check.name}", *said[begin:], sep="\n   ", flush=True)
    text = "\n".join(said)
    return ([f"{check.name}: nothing said '{words}'" for words in check.expect if words not in text] +
            [f"{check.name}: something said '{words}'" for words in check.never if words in text])


def main():
    parser = argparse.ArgumentParser(prog="bsp/emulated-board/camera-check", description=__doc__)
    parser.add_argument("--out", required=True, help="new folder for the output of the board")
    parser.add_argument("--only", default="", help="run only checks whose name contains this text")
    parser.add_argument("--images", help="folder of kernel and initramfs (build/board)", default=images.BUILT)
    options = parser.parse_args()
    base = images.built(options.images)
    problems = []
    for number, check in enumerate(CHECKS):
        if options.only in check.name:
            problems += carry_out(check, base, os.path.join(options.out, str(number)))
    return rig.report(problems)


if __name__ == "__main__":
    sys.exit(main())
