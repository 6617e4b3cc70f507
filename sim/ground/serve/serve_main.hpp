// ilp-ground serve: shows a live flight in a browser, and optionally commands it.
#pragma once

namespace ilp::serve {

/// Runs the subcommand until the process is ended; `argv[0]` is "serve". Returns the exit status only after --help (0),
/// if the work cannot be done (1), or if the command line is wrong (2).
int serve_main(int argc, char** argv);

}  // namespace ilp::serve
