// ilp-ground map-check
#pragma once

namespace ilp::ground {

/// argv[1] is the name of the subcommand. Returns the exit status.
int map_check_main(int argc, char** argv);

}  // namespace ilp::ground
