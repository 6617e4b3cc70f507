// ilp-ground compare MAP OTHER: the height difference to another terrain model.
#pragma once

namespace ilp::ground {

/// The exit status of the program; `argv[1]` is "compare".
int compare_main(int argc, char** argv);

}  // namespace ilp::ground
