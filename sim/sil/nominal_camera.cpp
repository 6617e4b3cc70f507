#include "sim/sil/nominal_camera.hpp"

#include "fsw/base/rng.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp::sil {
namespace {

constexpr std::uint64_t nominal_stream = 0x0CA3E4A;
constexpr double focal_error = 0.15;
constexpr double centre_error = 0.01;  // of the image's width

}  // namespace

CameraModel nominal_camera(const CameraModel& truth, std::uint64_t seed) {
  Rng rng(seed, nominal_stream);
  const auto symmetric = [&rng](double bound) { return bound * (2 * rng.uniform() - 1); };
  const double factor = 1 + symmetric(focal_error);
  CameraModel out = with_focal_length(truth, factor);
  out.cx += symmetric(centre_error * truth.width);
  out.cy += symmetric(centre_error * truth.width);
  return out;
}

}  // namespace ilp::sil
