#include "fsw/vision/twoview/robust/ransac_params.hpp"

#include "cfg/limits.hpp"

namespace ilp {

Status validate(const RansacParams& params) {
  if (!(params.threshold_px > 0) || !(params.threshold_px < 1000)) return {StatusCode::invalid_argument, 1};
  if (!(params.confidence > 0) || !(params.confidence < 1)) return {StatusCode::invalid_argument, 2};
  if (params.max_trials == 0 || params.max_trials > limits::max_ransac_trials) {
    return {StatusCode::invalid_argument, 3, params.max_trials};
  }
  if (!(params.min_parallax_px >= 0)) return {StatusCode::invalid_argument, 6};
  if (!(params.max_sigma_direction_rad > 0)) return {StatusCode::invalid_argument, 7};
  return {};
}

}  // namespace ilp
