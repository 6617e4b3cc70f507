// What an operator must know of the flight's camera first: the images did not determine it, or do not fit it.
#pragma once

#include <string>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::report {

/// Sentences: what was found out, what follows from it, and what to do. Empty where nothing is known against the
/// camera.
[[nodiscard]] std::vector<std::string> camera_lines(const intake::Flight& flight);

}  // namespace ilp::report
