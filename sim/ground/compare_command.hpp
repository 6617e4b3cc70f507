// ilp-ground compare MAP OTHER: compares the heights of a map with those of another terrain model.
#pragma once

namespace ilp::ground {

/// Runs the subcommand; `argv[1]` is "compare". Returns the exit status: 0 if the models were compared, however large
/// their difference is (also after --help); 1 if an input cannot be used or the output cannot be written; 2 if the
/// command line is wrong.
int compare_main(int argc, char** argv);

}  // namespace ilp::ground
