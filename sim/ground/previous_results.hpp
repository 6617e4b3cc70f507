// Results of an earlier run in the same folder, which must not be taken for parts of the new one.
#pragma once

#include <filesystem>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::ground {

/// Removes files that carry exactly the names that this program gives; anything else in the folder stays, and so do the
/// pictures of the flight's keyframes.
void remove_previous_results(const std::filesystem::path& folder, const intake::Flight& flight);

}  // namespace ilp::ground
