// What a flight found out about a camera that was not known, where the images did not determine it.
#pragma once

#include <string>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::report {

/// Sentences for the operator: what was found out, what follows from it, and what to do. Empty if the camera was given
/// or found.
[[nodiscard]] std::vector<std::string> unknown_camera_lines(const intake::Flight& flight);

}  // namespace ilp::report
