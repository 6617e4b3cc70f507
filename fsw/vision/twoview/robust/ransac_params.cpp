#include "fsw/vision/twoview/robust/ransac_params.hpp"

#include "cfg/limits.hpp"
#include "fsw/base/argument.hpp"

namespace ilp {

Status validate(const RansacParams& params) {
  if (!(params.threshold_px > 0) || !(params.threshold_px < 1000))
    return out_of_range(Argument::ransac_threshold, params.threshold_px);
  if (!(params.confidence > 0) || !(params.confidence < 1))
    return out_of_range(Argument::ransac_confidence, params.confidence);
  if (params.max_trials == 0 || params.max_trials > limits::max_ransac_trials) {
    return out_of_range(Argument::ransac_trials, params.max_trials);
  }
  return {};
}

}  // namespace ilp
