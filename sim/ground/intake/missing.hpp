// Lists data that has not come down, and where on the map it belongs.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fsw/vision/geometry/types.hpp"
#include "sim/ground/intake/flight_model.hpp"

namespace ilp::intake {

struct Missing {
  std::int64_t keyframe_id = 0;
  std::string what;
  std::int64_t strip_id = 0;   ///< 0: not known
  std::optional<Vec3> centre;  ///< of the camera; between its neighbours' where its own is not known
};

/// In order of keyframes: keyframes between others of which nothing came, missing records, products that were made and
/// did not come, and missing layers of products. Missing data may still be on its way, or may have been dropped on
/// board.
[[nodiscard]] std::vector<Missing> missing_of(const Flight& flight);

}  // namespace ilp::intake
