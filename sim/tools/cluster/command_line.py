"""How the scripts read their command line; sim/host/command_line.hpp is the same for programs."""

import argparse
import difflib
import sys

STATUSES = "0 done, 1 the work could not be done, 2 wrong call"


class Help(argparse.RawDescriptionHelpFormatter):
    """States the defaults that there are."""

    def _get_help_string(self, action):
        text = action.help or ""
        if action.default in (None, False, "", [], argparse.SUPPRESS) or "default" in text:
            return text
        return text + " (default: %(default)s)"


class Parser(argparse.ArgumentParser):
    """Names a mistaken option with the nearest right one."""

    def __init__(self, description, example, statuses=STATUSES, **more):
        super().__init__(description=description, epilog=f"Example: {example}\nExit status: {statuses}", formatter_class=Help,
                         allow_abbrev=False, **more)

    def error(self, message):
        known = [name for action in self._actions for name in action.option_strings]
        for word in sys.argv[1:]:
            name = word.split("=")[0]
            if not name.startswith("--") or len(name) == 2 or name in known:
                continue
            near = difflib.get_close_matches(name, known, 1)
            message = f"{name} is no option" + (f"; did you mean {near[0]}?" if near else "")
            break
        super().error(message)
