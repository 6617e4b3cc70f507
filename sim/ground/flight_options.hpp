// The options on a flight that ilp-ground and ilp-ground serve have in common.
#pragma once

#include <CLI/CLI.hpp>

#include "sim/ground/ground_run.hpp"

namespace ilp::ground {

/// --acknowledge, --score, --anchor, --map, --landing-sites and --title.
void add_flight_options(CLI::App& app, GroundOptions& options);

}  // namespace ilp::ground
