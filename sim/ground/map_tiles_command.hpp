// ilp-ground map-tiles: makes the map that a flight carries, from an orthoimage and a terrain model of an orbiter.
#pragma once

namespace ilp::ground {

/// Runs the subcommand; `argv[1]` is its name. Returns the exit status: 0 if the map was made (also after --help); 1 if
/// an input cannot be used or the output cannot be written; 2 if the command line is wrong.
int map_tiles_main(int argc, char** argv);

}  // namespace ilp::ground
