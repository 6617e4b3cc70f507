"""A recorded strip: images, their times, the camera."""
import os
import shutil
import subprocess


class Strip:
    """`frames` has (time in ns, path of the image)."""

    def __init__(self, folder):
        self.folder = folder
        self.frames = []
        with open(os.path.join(folder, "index.txt"), encoding="utf-8") as index:
            for line in index:
                words = line.split("#")[0].split()
                if words:
                    self.frames.append((int(words[0]), os.path.join(folder, words[1])))

    def camera(self):
        """The intrinsics as ilp-onboard wants them: pixel centres at integers."""
        with open(os.path.join(self.folder, "cameras.txt"), encoding="utf-8") as cameras:
            words = [line for line in cameras if line.strip() and line[0] != "#"][0].split()
        model, width, height, *numbers = words[1:]
        values = [float(number) for number in numbers]
        if model.startswith(("SIMPLE_", "RADIAL")):
            values = [values[0]] + values
        values[2] -= 0.5
        values[3] -= 0.5
        coefficients = values[4:]
        while coefficients and len(coefficients) < 4:
            coefficients.append(0.0)
        lens = ["fisheye"] if model.endswith("FISHEYE") else []
        return " ".join([width, height] + [repr(value) for value in values[:4]] + lens +
                        [repr(value) for value in coefficients])

    def copy_for_disk(self, folder):
        """Index and images only, all in one folder: what the board's disk of frames holds."""
        os.makedirs(os.path.join(folder, "images"))
        with open(os.path.join(folder, "index.txt"), "w", encoding="utf-8") as index:
            for time_ns, path in self.frames:
                name = "images/" + os.path.basename(path)
                shutil.copyfile(path, os.path.join(folder, name))
                index.write(f"{time_ns} {name}\n")


def render(ilp_sil, out, frames, settings=()):
    words = [ilp_sil, "--render-only", "--frames", str(frames), "--out", out]
    for setting in settings:
        words += ["--set", setting]
    subprocess.run(words, check=True, capture_output=True)
    return Strip(os.path.join(out, "flight"))
