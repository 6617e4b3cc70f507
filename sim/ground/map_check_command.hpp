// ilp-ground map-check FLIGHT MAP: registers the keyframes of a downlinked flight on an orbiter's map, as the flight
// software does it, to test the map.
#pragma once

namespace ilp::ground {

/// Runs the subcommand; `argv[1]` is its name. Returns the exit status: 0 if the check ran, whatever its fixes are
/// (also after --help); 1 if an input cannot be used or the output cannot be written; 2 if the command line is wrong.
int map_check_main(int argc, char** argv);

}  // namespace ilp::ground
