// `ilp-ground console`: the operator's side of the link in a terminal, or in a pipe.
#pragma once

namespace ilp::console {

/// `argv[0]` is the word `console`. 0 when all went well, 1 for a command that failed or stayed without answer, or a
/// connection that ended; other numbers are those of CLI11.
int console_main(int argc, char** argv);

}  // namespace ilp::console
