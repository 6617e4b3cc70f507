#include "sim/ground/report/camera_lines.hpp"

#include "fsw/vision/calibration/camera_check.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

/// What would determine it.
const char* remedy_of(Intrinsic open) {
  switch (open) {
    case Intrinsic::focal_length:
      return "relief, or a camera that tilts, best with attitudes or places of the vehicle (--navigation)";
    case Intrinsic::centre_x:
    case Intrinsic::centre_y:
    case Intrinsic::p1:
    case Intrinsic::p2:
      return "turns about the vertical, or a camera that tilts";
    default:
      return "a camera that tilts, relief, or attitudes or places of the vehicle (--navigation)";
  }
}

/// An error that is larger than this share of the one before an image was seen is open.
constexpr double hardly = 0.5;

void add_readout_line(const CalibrationRecord& said, std::vector<std::string>& lines) {
  if (!(said.sigma_readout_s > hardly * said.prior_sigma_readout_s)) return;
  lines.push_back("The readout time of the rolling shutter is as uncertain as it was given, by " +
                  host::brief(1e3 * said.sigma_readout_s) +
                  " ms. What would determine it: a camera that swings or turns.");
}

/// The intrinsics whose error is hardly smaller than before an image was seen, and the readout time if it is one.
std::vector<std::string> found_lines(const intake::Flight& flight) {
  if (!flight.camera_record || flight.calibrations.empty()) return {};
  const CalibrationRecord& said = flight.calibrations.rbegin()->second;
  std::vector<std::string> lines;
  if (!flight.camera_record->frozen) {
    lines.emplace_back(
        "The camera was not known, and the flight ended before it was found: no keyframe has a final pose.");
    return lines;
  }
  add_readout_line(said, lines);
  if (said.verdict == CalibrationVerdict::ok) return lines;
  lines.push_back("The camera was not known. Result from " + host::counted(said.keyframes, "keyframe") + ": " +
                  words_of(said.verdict) + ".");
  for (const Intrinsic intrinsic : {Intrinsic::focal_length, Intrinsic::k1}) {
    const auto i = static_cast<std::size_t>(intrinsic);
    if (!(said.prior_sigmas[i] > 0 && said.sigmas[i] > hardly * said.prior_sigmas[i])) continue;
    lines.push_back(std::string("Its ") + words_of(intrinsic) + " is as uncertain as it was given, by " +
                    host::brief(said.sigmas[i]) + (intrinsic == Intrinsic::focal_length ? " px" : "") +
                    ". What would determine it: " + remedy_of(intrinsic) + ".");
  }
  return lines;
}

/// "radial distortion k1 -0.0812 instead of -0.0900, by 9.3 sigmas", for the intrinsic that alone explains most.
std::string asked_for(const CalibrationCheckRecord& check, const CameraRecord& camera) {
  const double given[] = {camera.fx, camera.cx, camera.cy, camera.k1, camera.k2, camera.p1, camera.p2};
  const auto worst = static_cast<std::size_t>(check.worst);
  if (worst >= std::size(given)) return "";
  const double correction = check.worst_correction;
  const char* const unit = worst < 3 ? " px" : "";
  const int decimals = worst < 3 ? 1 : worst < 5 ? 4 : 5;
  return std::string(words_of(check.worst)) + " " + host::fixed(given[worst] + correction, decimals) + unit +
         " instead of " + host::fixed(given[worst], decimals) + unit + ", by " + host::brief(check.worst_sigmas) +
         " sigmas";
}

/// Up to so many times a limit, other causes than the camera may have made what the check found.
constexpr double weakly = 2;

std::string contradiction(const CalibrationCheckRecord& check, const CameraRecord& camera) {
  const bool weak = check.statistic < weakly * max_camera_statistic;
  return std::string(weak ? " fit the camera not quite" : " contradict the camera") + ": their statistic is " +
         host::brief(check.statistic) + ", above its limit of " + host::brief(max_camera_statistic) +
         ". They ask for " + asked_for(check, camera) + ", which moves the cameras of six keyframes by " +
         host::brief(100 * check.cost) + " % of their extent. " +
         (weak ? "Likely are a camera that is a little off (focus, temperature), or relief and turns that the check "
                 "does not quite bear; errors may be somewhat larger than estimated."
               : "Positions, heights and their estimated errors are wrong until the camera is right.");
}

std::string no_lens(const CalibrationCheckRecord& check) {
  const LensExcess excess = excess_of(check.statistic, check.spread, check.field);
  const bool by_windows = excess.of_spread >= excess.of_field, weak = excess.largest() < weakly;
  return std::string(weak ? " fit no lens quite" : " fit no lens") + ": what every lens leaves is " +
         host::brief(excess.largest()) + " times its limit (over " + host::counted(check.windows, "window") + "). " +
         (by_windows
              ? "Its windows ask for different lenses, " + host::brief(check.spread) +
                    " times as far apart as errors explain: likely a rolling shutter on a vehicle that swings, or "
                    "a zoom or focus that moved"
              : "In parts of the image the residuals stay " + host::brief(check.field) +
                    " times as large as errors explain: likely something has bent the images") +
         (weak ? "; estimated errors may be somewhat too small." : "; estimated errors are too small.");
}

std::vector<std::string> contradiction_lines(const intake::Flight& flight) {
  std::vector<std::string> lines;
  for (const auto& [strip, check] : flight.camera_checks) {
    const std::string images = "The images of strip " + std::to_string(strip);
    if (check.verdict == CameraCheckVerdict::contradicts && flight.camera_record) {
      lines.push_back(images + contradiction(check, *flight.camera_record));
    } else if (check.verdict == CameraCheckVerdict::unexplained) {
      lines.push_back(images + no_lens(check));
    }
  }
  if (!lines.empty()) {
    lines.emplace_back(
        "What to do: check the camera file (size, focus, zoom), or measure the camera (ilp-lab calibrate-target). With "
        "a "
        "rolling shutter state its readout time (# readout_s), or let the flight find it ([calibration] "
        "readout_sigma_s).");
  }
  return lines;
}

}  // namespace

std::vector<std::string> camera_lines(const intake::Flight& flight) {
  std::vector<std::string> lines = found_lines(flight);
  for (std::string& line : contradiction_lines(flight)) lines.push_back(std::move(line));
  return lines;
}

}  // namespace ilp::report
