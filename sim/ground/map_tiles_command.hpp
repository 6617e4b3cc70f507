// ilp-ground map-tiles
#pragma once

namespace ilp::ground {

/// argv[1] is the name of the subcommand. Returns the exit status.
int map_tiles_main(int argc, char** argv);

}  // namespace ilp::ground
