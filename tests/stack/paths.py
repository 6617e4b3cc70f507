"""The deepest paths through a program's calls, with the calls through pointers of wiring.py and the bounds of
libraries.txt."""
import bisect
import pathlib
import re

import wiring

LIBRARIES = pathlib.Path(__file__).with_name("libraries.txt")


class Bound:
    """Functions of which at most `times` are on the stack at once; zero times: they never run."""

    def __init__(self, line):
        times, pattern, self.reason = re.split(r"\s{2,}", line.strip(), maxsplit=2)
        self.times, self.pattern = int(times), re.compile(pattern)


def plain(name):
    """Without what the compiler adds to the name of a part or a copy of a function."""
    return re.sub(r"( \[clone [^\]]*\])+$|\.(part|constprop|isra|cold)\b.*$", "", name)


class Graph:
    """What calls what, from `roots` (addresses) down."""

    def __init__(self, program, roots):
        self.program, self.functions = program, program.functions
        self.name = {at: plain(function.name) for at, function in self.functions.items()}
        self.classes = self.virtual_functions()
        self.bounds = [Bound(line) for line in LIBRARIES.read_text(encoding="utf-8").splitlines()]
        self.targets_of, self.row_of, self.bound_of = {}, {}, {}
        self.roots = [at for at, name in self.name.items() if any(re.fullmatch(root, name) for root in roots)]
        self.calls, waiting = {}, list(self.roots)
        while waiting:
            at = waiting.pop()
            if at not in self.calls:
                self.calls[at] = self.calls_of(at)
                waiting += self.calls[at]

    def virtual_functions(self):
        """Of each class that has some: {name without namespaces: addresses}."""
        tables = self.program.tables()
        words, classes = sorted(tables), {}
        for name, (at, size) in self.program.symbols().items():
            if name.startswith("vtable for "):
                inside = words[bisect.bisect_left(words, at):bisect.bisect_left(words, at + size)]
                classes[name.split("::")[-1]] = {tables[word] for word in inside}
        return classes

    def targets(self, callees):
        if callees not in self.targets_of:
            found = set()
            for callee in callees:
                classes = wiring.INTERFACES.get(callee, callee).split()
                if all(name in self.classes for name in classes):
                    found.update(*(self.classes[name] for name in classes))
                elif callee in wiring.INTERFACES:
                    found.update(*(self.classes.get(name, ()) for name in classes))
                else:
                    found |= {at for at, name in self.name.items() if re.fullmatch(callee, name)}
            self.targets_of[callees] = found
        return self.targets_of[callees]

    def row(self, at):
        """The row of wiring.CALLS that says what a function calls through pointers."""
        name = self.name[at]
        if name not in self.row_of:
            self.row_of[name] = next((row for row in wiring.CALLS if row.pattern.match(name)), None)
        return self.row_of[name]

    def bound(self, at):
        name = self.name[at]
        if name not in self.bound_of:
            self.bound_of[name] = next((bound for bound in self.bounds if bound.pattern.fullmatch(name)), None)
        return self.bound_of[name]

    def is_elsewhere(self, at):
        """Of a library that is loaded; or, in a static program, chosen by the loader among a few that take nothing."""
        return "@plt" in self.name[at] or self.name[at] == ".plt"

    def frame(self, at):
        if self.is_elsewhere(at):
            return next(octets for pattern, octets in wiring.C_LIBRARY_BYTES if pattern.match(self.name[at]))
        return self.functions[at].frame + wiring.DYNAMIC_BYTES.get(self.name[at], 0)

    def calls_of(self, at):
        """{address: depth at the call}, without what never runs."""
        if self.is_elsewhere(at):
            return {}
        function = self.program.function(at)
        calls = dict(function.calls)
        if function.indirect >= 0 and self.row(at) is not None:
            for target in self.targets(self.row(at).callees) - {at}:
                calls[target] = max(function.indirect, calls.get(target, 0))
        more = wiring.DYNAMIC_BYTES.get(self.name[at], 0)
        return {to: depth + more for to, depth in calls.items() if self.bound(to) is None or self.bound(to).times > 0}


def components(calls):
    """Strongly connected ones, callees first (Tarjan), each as a list of addresses."""
    index, low, stack, on_stack, found = {}, {}, [], set(), []
    for root in calls:
        if root in index:
            continue
        index[root] = low[root] = len(index)
        stack.append(root)
        on_stack.add(root)
        work = [(root, iter(calls[root]))]
        while work:
            at, rest = work[-1]
            for callee in rest:
                if callee not in index:
                    index[callee] = low[callee] = len(index)
                    stack.append(callee)
                    on_stack.add(callee)
                    work.append((callee, iter(calls[callee])))
                    break
                if callee in on_stack:
                    low[at] = min(low[at], index[callee])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[at])
                if low[at] == index[at]:
                    found.append(stack[stack.index(at):])
                    del stack[len(stack) - len(found[-1]):]
                    on_stack -= set(found[-1])
    return found


class Paths:
    """The deepest path below each function that runs, and the cycles that nothing bounds."""

    def __init__(self, graph):
        self.graph, self.calls = graph, graph.calls
        self.below, self.turn, self.next, self.cycles = {}, {}, {}, []
        self.order = components(self.calls)
        for component in self.order:
            self.add(component)

    def add(self, component):
        inside, heads = set(component), {}
        cyclic = len(component) > 1 or component[0] in self.calls[component[0]]
        for at in component if cyclic else ():
            if self.graph.bound(at) is not None:
                heads.setdefault(self.graph.bound(at), []).append(at)
        cut = {at for of_bound in heads.values() for at in of_bound}
        # Without the calls of those that are bounded there is no cycle left, or it is a finding.
        left = {at: [to for to in self.calls[at] if to in inside and to not in cut] for at in component}
        for part in components(left):
            if len(part) > 1 or part[0] in left[part[0]]:
                self.cycles.append(part)
            for at in part:
                self.deepest(at, cut, inside)
        if not cut:
            return
        # They take turns, each as often as it may, and from the last one the way leads out.
        turns = [(bound.times, max(self.turn[at] for at in of_bound)) for bound, of_bound in heads.items()]
        rounds = sum(times * turn for times, turn in turns) - min(turn for _, turn in turns)
        way_out = max(self.below[at] for at in cut)
        for at in component:
            self.below[at] = max(self.below[at], (0 if at in cut else self.turn[at]) + rounds + way_out)

    def deepest(self, at, cut, inside):
        best, callee, turn = self.graph.frame(at), None, 0
        for to, depth in self.calls[at].items():
            if to in inside:
                turn = max(turn, depth + (0 if to in cut else self.turn.get(to, 0)))
            below = depth + (0 if to in cut else self.below.get(to, 0))
            if below > best:
                best, callee = below, to
        self.below[at], self.next[at], self.turn[at] = best, callee, turn

    def above(self, targets):
        """Of each function that reaches `targets`: the deepest way to the call of one of them."""
        above = {}
        for component in self.order:
            for at in component:
                ways = [depth + above.get(to, 0) for to, depth in self.calls[at].items() if to in targets or to in above]
                if ways and at not in targets:
                    above[at] = max(ways)
        return above

    def path(self, at):
        """The functions of the deepest path, a bounded cycle once, each with what is below it and its own frame."""
        lines, seen = [], set()
        while at is not None and at not in seen:
            seen.add(at)
            lines.append(f"{self.below[at]:8} {self.graph.frame(at):6} {self.graph.name[at]}")
            at = self.next[at]
        return lines
