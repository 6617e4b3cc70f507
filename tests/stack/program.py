"""Reads a linked program (ELF, x86-64 or aarch64) from its disassembly: its functions, how much of the stack each of them
takes, and what it calls.

Depths are counted from the stack pointer that a function is entered with, and follow the instructions in their order;
after a jump they are those of the place that jumps there. Where nothing is known the largest depth so far is taken.
"""
import bisect
import dataclasses
import pathlib
import re
import subprocess

WORD = 8
# A part of a function that lies elsewhere, and goes back into the middle of it: what is unlikely, or by-passes a fault
# of the processor
PART = re.compile(r"\.cold\]?$|^e843419@")
PAGE = 4096


@dataclasses.dataclass
class Function:
    name: str
    at: int
    text: str
    end: int = 0
    frame: int = 0                                   # the deepest, without what is called
    calls: dict = dataclasses.field(default_factory=dict)   # address: deepest, return address included
    indirect: int = -1                               # the deepest of its indirect calls, return address included
    dynamic: list = dataclasses.field(default_factory=list)  # what it takes by an amount known at run time only

    def call(self, target, depth):
        self.calls[target] = max(depth, self.calls.get(target, 0))


class Depths:
    """The depth at each place of a function, in the order of its instructions."""

    def __init__(self, function):
        self.function, self.now, self.of_base, self.flows, self.at_target = function, 0, 0, True, {}

    def arrive(self, at):
        if not self.flows:
            self.now = self.at_target.get(at, self.function.frame)
        elif at in self.at_target:
            self.now = max(self.now, self.at_target[at])
        self.flows = True

    def set(self, depth):
        self.now = depth
        self.function.frame = max(self.function.frame, depth)

    def take(self, octets):
        self.set(self.now + octets)

    def jump(self, target, program):
        function = self.function
        if function.at <= target < function.end:
            self.at_target[target] = max(self.now, self.at_target.get(target, 0))
        elif target in program.functions or not PART.search(function.name):
            function.call(program.start_of(target), self.now)


def signed(text):
    value = int(text, 0)
    return value - (1 << 64) if value >> 63 else value


def target(operands):
    """The address of a branch, which objdump writes before its name."""
    return int(re.search(r"\b([0-9a-f]+)( <|$)", operands)[1], 16)


class X86:
    sub = re.compile(r"\$(-?0x[0-9a-f]+|-?\d+),%rsp$")
    lea = re.compile(r"(-?0x[0-9a-f]+)?\(%(\w+)\),%(\w+)$")

    @classmethod
    def read(cls, program, function):
        depths, before, kept = Depths(function), ("", ""), {}
        for at, verb, operands in program.instructions(function):
            depths.arrive(at)
            if verb.startswith("push"):
                depths.take(WORD)
            elif verb.startswith("pop"):
                depths.take(-WORD)
            elif verb == "call":
                cls.indirect_or(program, function, depths.now + WORD, operands, function.call)
            elif verb in ("jmp", "notrack jmp", "bnd jmp"):
                if not operands.startswith("*"):
                    depths.jump(target(operands), program)
                elif not cls.is_table(before, operands):
                    cls.indirect_or(program, function, depths.now, operands, function.call)
                depths.flows = False
            elif verb[0] == "j":
                depths.jump(target(operands), program)
            elif "ret" in verb or verb in ("ud2", "hlt"):
                depths.flows = False
            elif verb == "leave":
                depths.set(depths.of_base - WORD)
            elif operands.endswith("%rsp") and verb not in ("cmp", "test"):
                cls.move(depths, verb, operands, kept)
            elif verb == "mov" and operands.startswith("%rsp,%"):
                kept[operands[5:]] = depths.now
                depths.of_base = kept.get("%rbp", 0)
            elif verb == "lea" and operands.endswith("(%rsp),%r11") and operands.startswith("-"):
                probed = -int(operands.split("(")[0], 16)
            elif verb == "cmp" and operands == "%r11,%rsp" and before == ("orq", "$0x0,(%rsp)"):
                depths.take(probed - PAGE)  # a loop that touches each page
            before = verb, operands

    @classmethod
    def move(cls, depths, verb, operands, kept):
        amount, lea = cls.sub.match(operands), cls.lea.match(operands)
        if amount and verb == "sub":
            depths.take(signed(amount[1]))
        elif amount and verb == "add":
            depths.take(-signed(amount[1]))
        elif amount and verb == "and":
            depths.take(-signed(amount[1]) - WORD)
        elif verb == "lea" and lea and lea[2] == "rsp":
            depths.take(-int(lea[1] or "0", 16))
        elif verb == "lea" and lea and lea[2] == "rbp":
            depths.set(depths.of_base - int(lea[1] or "0", 16))
        elif verb == "lea" and lea:
            depths.set(0)  # the caller's, kept in a register where the frame is aligned
        elif verb == "mov" and operands[:-5] in kept:
            depths.set(kept[operands[:-5]])
        else:
            depths.function.dynamic.append(f"{verb} {operands}")

    @staticmethod
    def is_table(before, operands):
        """A jump into a table of branches: to an address that was added up, or read by an index."""
        return (before[0] == "add" and before[1].endswith("," + operands[1:])) or "*8)" in operands or ",8)" in operands

    @staticmethod
    def indirect_or(program, function, depth, operands, call):
        if not operands.startswith("*"):
            call(program.start_of(target(operands)), depth)
        elif "(%rip)" not in operands or "@" not in operands:  # not by the loader's table to another library
            function.indirect = max(function.indirect, depth)


class Aarch64:
    pair = re.compile(r"\[sp, #(-\d+)\]!$")
    release = re.compile(r"\[sp\], #(\d+)$")
    amount = re.compile(r"(\w+), (\w+), #(0x[0-9a-f]+|\d+)(?:, lsl #(\d+))?$")
    constant = re.compile(r"[xw](\d+), #(0x[0-9a-f]+|-?\d+)(?:, lsl #(\d+))?$")
    registers = re.compile(r"sp, (\w+), x(\d+)(?:, (.*))?$")

    @classmethod
    def read(cls, program, function):
        depths, before, known = Depths(function), ("", ""), {}
        aligned = 0
        for at, verb, operands in program.instructions(function):
            depths.arrive(at)
            operands = operands.split("//")[0].strip()
            if verb in ("stp", "str", "ldp", "ldr"):
                taken, released = cls.pair.search(operands), cls.release.search(operands)
                if taken:
                    depths.take(-int(taken[1]))
                elif released:
                    depths.take(-int(released[1]))
            elif verb == "bl":
                function.call(program.start_of(target(operands)), depths.now)
            elif verb in ("blr", "blraa", "blraaz"):
                function.indirect = max(function.indirect, depths.now)
            elif verb == "br":
                if operands != "x30" and not (before[0] == "add" and before[1].startswith(operands.split(",")[0] + ",")):
                    function.indirect = max(function.indirect, depths.now)
                depths.flows = False
            elif verb == "b":
                depths.jump(target(operands), program)
                depths.flows = False
            elif verb.startswith(("b.", "cbz", "cbnz", "tbz", "tbnz")):
                depths.jump(target(operands), program)
            elif verb.startswith("ret") or verb in ("udf", "brk"):
                depths.flows = False
            elif verb in ("mov", "movk") and cls.constant.match(operands):
                register, value, shift = cls.constant.match(operands).groups()
                value = int(value, 0) << int(shift or 0)
                known[register] = known.get(register, 0) | value if verb == "movk" else value
                continue
            elif operands == "x29, sp":
                depths.of_base = depths.now
            elif operands.startswith("x29, sp, #") and verb == "add":
                depths.of_base = depths.now - int(operands.split("#")[1], 0)
            elif operands.startswith("sp, "):
                cls.move(depths, verb, operands, known, aligned)
            elif verb == "sub" and cls.amount.match(operands) and cls.amount.match(operands)[2] == "sp":
                aligned = int(cls.amount.match(operands)[3], 0)
            if operands[:1] in ("x", "w"):
                known.pop(operands.split(",")[0][1:], None)
            before = verb, operands

    @classmethod
    def move(cls, depths, verb, operands, known, aligned):
        amount, registers = cls.amount.match(operands), cls.registers.match(operands)
        if amount and verb in ("sub", "add"):
            octets = int(amount[3], 0) << int(amount[4] or 0)
            octets = octets if verb == "sub" else -octets
            depths.set((depths.of_base if amount[2] == "x29" else depths.now) + octets)
        elif amount and verb == "and":
            depths.take(aligned + (-signed(amount[3]) if int(amount[3], 0) >> 63 else 0))
        elif operands == "sp, x29":
            depths.set(depths.of_base)
        elif registers and registers[1] == "sp" and registers[2] in known:
            depths.take(known[registers[2]] if verb == "sub" else -known[registers[2]])
        else:
            depths.function.dynamic.append(f"{verb} {operands}")


class Program:
    """A program, of which a function is read when it is asked for."""

    def __init__(self, path, prefix=""):
        self.path = pathlib.Path(path)
        text = self.run(prefix + "objdump", "--disassemble", "--demangle", "--no-show-raw-insn", "--wide")
        self.machine = Aarch64 if "file format elf64-littleaarch64" in text[:200] else X86
        # Labels inside hand-written functions of libraries are no functions.
        heads = [head for head in re.finditer(r"^([0-9a-f]{16}) <(.*)>:\n", text, re.MULTILINE)
                 if not re.match(r"\._|\.\.@|jsimd_\w+\.", head[2])]
        self.functions = {}
        for head, after in zip(heads, heads[1:] + [None]):
            at = int(head[1], 16)
            self.functions[at] = Function(head[2], at, text[head.end():after.start() if after else len(text)])
        self.starts = sorted(self.functions)
        for start, end in zip(self.starts, self.starts[1:] + [1 << 63]):
            self.functions[start].end = end
        self.prefix = prefix
        self.unread = set(self.functions)

    def run(self, *command):
        return subprocess.run([*command, str(self.path)], check=True, stdout=subprocess.PIPE, text=True).stdout

    @staticmethod
    def instructions(function):
        for line in function.text.splitlines():
            head, colon, rest = line.partition(":\t")
            if colon:
                verb, *operands = rest.split(None, 1)
                if verb in ("notrack", "bnd", "repz", "rep", "lock", "cs") and operands:
                    verb, *operands = operands[0].split(None, 1)
                yield int(head, 16), verb, operands[0].rstrip() if operands else ""

    def start_of(self, address):
        """Of the function that it lies in."""
        if address in self.functions:
            return address
        return self.starts[max(bisect.bisect_right(self.starts, address) - 1, 0)]

    def function(self, at):
        function = self.functions[at]
        if at in self.unread:
            self.unread.discard(at)
            if "@plt" in function.name or function.name == ".plt":
                return function  # jumps to another library
            self.machine.read(self, function)
        return function

    def tables(self):
        """Addresses of functions in data that the loader relocates: {address of the word: address of the function}."""
        words = {}
        for line in self.run(self.prefix + "readelf", "--relocs", "--wide").splitlines():
            fields = line.split()
            if len(fields) == 4 and fields[2].endswith("_RELATIVE") and int(fields[3], 16) in self.functions:
                words[int(fields[0], 16)] = int(fields[3], 16)
        return words

    def taken(self, functions):
        """Addresses of functions that instructions of `functions` take, or data that the loader relocates (x86-64)."""
        taken = set(self.tables().values())
        for at in functions:
            found = re.findall(r"\tlea .*\(%rip\).* # ([0-9a-f]+) <", self.functions[at].text)
            taken |= {int(address, 16) for address in found}
        return taken & set(self.functions)

    def symbols(self):
        """Of data and functions, with their sizes: {name: (address, size)}."""
        found = {}
        for line in self.run(self.prefix + "nm", "--demangle", "--print-size").splitlines():
            fields = line.split(None, 3)
            if len(fields) == 4:
                found[fields[3]] = int(fields[0], 16), int(fields[1], 16)
        return found
