"""The emulated board: one QEMU process with its disks, its network port and its console."""
import os
import re
import selectors
import signal
import socket
import subprocess
import sys
import time

MEMORY_MIB = 512
NS_PER_INSTRUCTION_SHIFT = 0  # in real time: 1 ns, a processor of 1000 MIPS
COMMAND_LINE = "console=ttyAMA0 loglevel=4 panic=-1 mitigations=off"
LINK_PORT = 5000  # of the board, where ilp-onboard listens


class BoardError(Exception):
    """The board did not do what was expected; the text says what its console said last."""


def report(problems, most=None, well="0 problems"):
    """Prints what went wrong; the program's exit status."""
    for problem in problems[:most]:
        print(f"PROBLEM: {problem}")
    print(f"{len(problems)} problems" if problems else well)
    return 1 if problems else 0


def run(main, name):
    """Runs a program of the rig, which says in one line why the board has failed it."""
    try:
        sys.exit(main())
    except BoardError as error:
        sys.exit(f"{name}: {error}")


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def machine(images, kernel_arguments, deterministic, ns_per_instruction_shift, watchdog):
    """QEMU's words for the processor, the memory and what is booted."""
    words = ["qemu-system-aarch64", "-cpu", "cortex-a57", "-smp", "1", "-m", str(MEMORY_MIB)]
    if deterministic:
        # Time is the number of instructions, 4 ns each, and nothing comes from outside.
        words += ["-M", "virt,gic-version=3,dtb-randomness=off", "-accel", "tcg,thread=single,tb-size=256",
                  "-icount", "shift=2,sleep=off", "-rtc", "clock=vm,base=2026-01-01T00:00:00", "-seed", "1"]
        kernel_arguments += " nokaslr norandmaps"
    else:
        # The board's clock follows its instructions, so that a busy host makes it late but no slower in its own time;
        # while the board sleeps it runs like the host's.
        words += ["-M", "virt,gic-version=3", "-accel", "tcg,thread=single,tb-size=256",
                  "-icount", f"shift={ns_per_instruction_shift},sleep=on", "-rtc", "base=utc,clock=vm"]
    # A reset by the watchdog is one within the life of the machine; without a watchdog a reset is an end.
    words += ["-device", "i6300esb", "-action", "watchdog=reset"] if watchdog else ["-no-reboot"]
    return words + ["-display", "none", "-nodefaults", "-serial", "stdio",
                    "-kernel", images.kernel, "-initrd", images.initramfs,
                    "-append", f"{COMMAND_LINE} {kernel_arguments}".strip()]


def data_disk(disk, write_log, read_only):
    """The disk that the database lives on; with a write log every write and flush is noted for power cuts."""
    if write_log is None:
        # A flush is done at once, whatever else the host writes: what QEMU was told outlives its end in any case.
        words = ["-drive", f"file={disk},if=none,id=data,format=raw,cache=unsafe"
                 + (",readonly=on" if read_only else "")]
    else:
        open(write_log, "wb").close()
        words = ["-blockdev", f"driver=file,node-name=file0,filename={disk}",
                 "-blockdev", f"driver=file,node-name=log0,filename={write_log}",
                 "-blockdev", "driver=blklogwrites,node-name=data,file=file0,log=log0,log-super-update-interval=1"]
    return words + ["-device", "virtio-blk-pci,drive=data,serial=data"]


class Board:
    """Started by the constructor; `console` has every line that it has printed, with the host's time in seconds."""

    def __init__(self, images, log_path, disk=None, frames=None, link_port=None, write_log=None, deterministic=False,
                 kernel_arguments="", disk_read_only=False, watchdog=False,
                 ns_per_instruction_shift=NS_PER_INSTRUCTION_SHIFT):
        words = machine(images, kernel_arguments, deterministic, ns_per_instruction_shift, watchdog)
        if disk is not None:
            words += data_disk(disk, write_log, disk_read_only)
        if frames is not None:
            words += ["-drive", f"file={frames},if=none,id=frames,format=raw,readonly=on",
                      "-device", "virtio-blk-pci,drive=frames,serial=frames"]
        if link_port is not None:
            # The board reaches nobody; the host reaches its one port.
            words += ["-netdev", f"user,id=n0,restrict=on,hostfwd=tcp:127.0.0.1:{link_port}-:{LINK_PORT}",
                      "-device", "virtio-net-pci,netdev=n0,romfile="]
        if not deterministic:
            words += ["-device", "virtio-rng-pci"]
        self.begin = time.monotonic()
        self.console = []
        self._rest = b""
        self._log = open(log_path, "w", encoding="utf-8")
        self._log.write(" ".join(words) + "\n")
        self.process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self._ended = False
        os.set_blocking(self.process.stdout.fileno(), False)
        self._selector = selectors.DefaultSelector()
        self._selector.register(self.process.stdout, selectors.EVENT_READ)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.kill()
        self._log.close()

    def _take(self, octets):
        *lines, self._rest = (self._rest + octets).split(b"\n")
        for line in lines:
            text = line.decode("utf-8", "replace").rstrip("\r")
            at = time.monotonic() - self.begin
            self.console.append((at, text))
            self._log.write(f"{at:9.3f} {text}\n")
            self._log.flush()

    def listen(self, seconds):
        """Reads the console for up to this many seconds; False once the board is off."""
        if self._ended:
            return False
        for _ in self._selector.select(seconds):
            octets = os.read(self.process.stdout.fileno(), 65536)
            if octets:
                self._take(octets)
            else:
                self._ended = True
                self.process.wait()
        return not self._ended

    def lines(self, pattern):
        """Matches of the pattern in what the console has said."""
        found = (re.search(pattern, text) for _, text in self.console)
        return [match for match in found if match]

    def wait_for(self, pattern, seconds):
        """The first line that matches, already printed or to come."""
        end = time.monotonic() + seconds
        while True:
            found = self.lines(pattern)
            if found:
                return found[0]
            if not self.listen(0.1):
                raise BoardError(f"the board is off before it said '{pattern}'; it said:\n{self.tail()}")
            if time.monotonic() > end:
                raise BoardError(f"no '{pattern}' within {seconds} s; the board said:\n{self.tail()}")

    def wait_until_off(self, seconds):
        self.wait_for("^board: .* off$", seconds)
        end = time.monotonic() + 30
        while self.listen(0.1) and time.monotonic() < end:
            pass
        return self.process.poll()

    def stop(self, seconds=120):
        """A clean end: the program that runs gets SIGTERM, disks are unmounted, the power goes."""
        self.process.stdin.write(b"stop\n")
        self.process.stdin.flush()
        return self.wait_until_off(seconds)

    def kill(self):
        """The power goes now."""
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    def tail(self, count=15):
        return "\n".join(text for _, text in self.console[-count:])
