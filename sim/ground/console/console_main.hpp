// ilp-ground console: operates a flight over its link, in a terminal or with a script from a pipe.
#pragma once

namespace ilp::console {

/// Runs the subcommand; `argv[0]` is "console". Returns the exit status: 1 if the flight cannot be reached or has
/// closed the connection, or a command of a script failed or got no answer; 2 if the command line is wrong; else 0.
int console_main(int argc, char** argv);

}  // namespace ilp::console
