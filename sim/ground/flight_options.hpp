// The command-line options that ilp-ground and ilp-ground serve have in common.
#pragma once

#include <CLI/CLI.hpp>

#include "sim/ground/ground_run.hpp"

namespace ilp::ground {

/// Adds --acknowledge, --score, --anchor, --map, --landing-sites and --title, which set members of `options`.
void add_flight_options(CLI::App& app, GroundOptions& options);

}  // namespace ilp::ground
