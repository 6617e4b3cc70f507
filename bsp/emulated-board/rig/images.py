"""Files that the board boots from and flies with: first file system, disks."""
import os
import shutil
import subprocess
import tempfile

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "../../.."))
BUILT = os.path.join(ROOT, "build/board")
BOARD_PROGRAMS = os.path.join(ROOT, "build/aarch64/bin")


class Images:
    """What a board boots."""

    def __init__(self, kernel, initramfs):
        self.kernel = kernel
        self.initramfs = initramfs


def built(folder=BUILT):
    """What `prepare` leaves."""
    return Images(os.path.join(folder, "kernel/vmlinuz"), os.path.join(folder, "initramfs.cpio"))


def cpio(folder):
    """The folder as an archive that the kernel unpacks over the first file system."""
    names = subprocess.run(["find", ".", "-print0"], cwd=folder, check=True, capture_output=True).stdout
    names = b"\0".join(sorted(names.split(b"\0")[:-1]))
    for path, folders, files in os.walk(folder):
        for name in folders + files:
            os.utime(os.path.join(path, name), (0, 0))
    os.utime(folder, (0, 0))
    words = ["cpio", "-0", "-o", "-H", "newc", "-R", "0:0", "--reproducible", "--quiet"]
    return subprocess.run(words, cwd=folder, input=names, check=True, capture_output=True).stdout


def with_flight(images, flight, output, programs=()):
    """`flight` names files of the host by their names in the board's folder /flight; texts may be given as bytes.
    `programs` has (name in the board's folder /bin, name of what was built)."""
    with tempfile.TemporaryDirectory() as folder:
        for name, source in programs:
            os.makedirs(os.path.join(folder, "bin"), exist_ok=True)
            subprocess.run(["aarch64-linux-gnu-strip", "-o", os.path.join(folder, "bin", name),
                            os.path.join(BOARD_PROGRAMS, source)], check=True)
        for name, content in flight.items():
            path = os.path.join(folder, "flight", name)
            os.makedirs(os.path.dirname(path), exist_ok=True)
            if isinstance(content, bytes):
                with open(path, "wb") as file:
                    file.write(content)
            else:
                shutil.copyfile(content, path)
        archive = cpio(folder)
    with open(output, "wb") as file, open(images.initramfs, "rb") as base:
        shutil.copyfileobj(base, file)
        file.write(archive)
    return Images(images.kernel, output)


def make_disk(path, mebibytes, folder=None):
    """An ext4 disk, empty or with the folder's files; always the same bytes."""
    with open(path, "wb") as file:
        file.truncate(mebibytes << 20)
    words = ["/sbin/mke2fs", "-q", "-F", "-t", "ext4", "-U", "11111111-2222-3333-4444-555555555555",
             "-E", "hash_seed=11111111-2222-3333-4444-555555555555,lazy_itable_init=0,lazy_journal_init=0"]
    words += ["-d", folder] if folder else []
    subprocess.run(words + [path], check=True, env={**os.environ, "E2FSPROGS_FAKE_TIME": "1767225600"})


def check_disk(path):
    """Replays the journal and repairs as a board's start would; e2fsck's exit status (0 or 1 is healthy)."""
    return subprocess.run(["/sbin/e2fsck", "-f", "-y", path], capture_output=True).returncode


def read_disk(path, folder):
    """Copies every file of the disk into the folder; no mount, no root."""
    os.makedirs(folder, exist_ok=True)
    subprocess.run(["/sbin/debugfs", "-R", f"rdump / {folder}", path], capture_output=True, check=True)
