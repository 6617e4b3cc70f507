// `ilp-ground console`: the operator's side of the link in a terminal, or in a pipe.
#pragma once

namespace ilp::console {

/// `argv[0]` is the word `console`. Returns 0 when all went well, and 1 if a command failed or got no answer or the
/// connection ended; other numbers are those of CLI11.
int console_main(int argc, char** argv);

}  // namespace ilp::console
