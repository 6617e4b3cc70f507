// Warns the operator about the flight's camera: the images did not determine it, or do not fit it.
#pragma once

#include <string>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::report {

/// Sentences on what was found, what follows from it, and what to do. Empty if nothing indicates a wrong camera.
[[nodiscard]] std::vector<std::string> camera_lines(const intake::Flight& flight);

}  // namespace ilp::report
