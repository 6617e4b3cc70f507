// Results of an earlier run in the same folder, which must not be taken for parts of the new one.
#pragma once

#include <filesystem>

namespace ilp::ground {

/// Removes files that carry exactly the names that this program gives; anything else in the folder stays.
void remove_previous_results(const std::filesystem::path& folder);

}  // namespace ilp::ground
