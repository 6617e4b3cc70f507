#include "sim/ground/report/camera_lines.hpp"

#include <map>

#include "fsw/vision/calibration/camera_check.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

/// The verdict that most keyframes ended with; those with too few keyframes for a set have none.
CalibrationVerdict usual_verdict(const intake::Flight& flight) {
  std::map<CalibrationVerdict, std::size_t> counts;
  CalibrationVerdict usual = CalibrationVerdict::collecting;
  for (const auto& [id, record] : flight.calibrations) {
    if (record.verdict == CalibrationVerdict::collecting || record.verdict == CalibrationVerdict::ok) continue;
    if (++counts[record.verdict] > counts[usual]) usual = record.verdict;
  }
  return usual;
}

const char* remedy_of(CalibrationVerdict verdict) {
  switch (verdict) {
    case CalibrationVerdict::planar:
      return "fly over relief, or let the vehicle measure attitude and height (--navigation): with them level ground "
             "determines the focal length too";
    case CalibrationVerdict::critical_motion:
      return "let the camera tilt, so that its optical axes spread by about 0.1 rad over four to six keyframes";
    case CalibrationVerdict::too_little_parallax:
      return "move the camera across the ground";
    case CalibrationVerdict::too_few_matches:
      return "take images that overlap more and show more texture";
    default:
      return "take more images, with relief and a camera that tilts";
  }
}

std::vector<std::string> not_found_lines(const intake::Flight& flight) {
  if (!flight.camera_record || flight.calibrations.empty()) return {};
  const bool frozen = flight.camera_record->frozen;
  if (frozen && flight.camera_record->source != CameraSource::nominal) return {};
  const CalibrationVerdict verdict = usual_verdict(flight);
  std::vector<std::string> lines = {"The camera was not known, and the images of " +
                                    host::counted(flight.calibrations.size(), "keyframe") +
                                    " do not determine it. Found out: " + words_of(verdict) + "."};
  if (frozen) {
    lines.push_back(
        "The flight went on with the nominal camera: shapes are right, heights are as wrong as its focal "
        "length.");
  } else {
    lines.emplace_back("Without a camera no keyframe gets a pose or a depth; only images came down.");
  }
  std::string remedy =
      "What to do: give the intrinsics (--camera; ilp-lab calibrate finds them from other images of "
      "this camera)";
  if (!frozen)
    remedy += "; or fly with the nominal camera ([calibration] calibration_fallback = nominal in the mission)";
  lines.push_back(remedy + "; or " + remedy_of(verdict) + ".");
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

std::vector<std::string> contradiction_lines(const intake::Flight& flight) {
  std::vector<std::string> lines;
  for (const auto& [strip, check] : flight.camera_checks) {
    const std::string images = "The images of strip " + std::to_string(strip);
    if (check.verdict == CameraCheckVerdict::contradicts && flight.camera_record) {
      lines.push_back(images + " contradict the camera: they ask for " + asked_for(check, *flight.camera_record) +
                      ". Positions, heights and their stated errors are wrong until the camera is right.");
    } else if (check.verdict == CameraCheckVerdict::unexplained) {
      const CameraCheckParams limits;
      const bool by_windows = check.spread / limits.max_spread >= check.field / limits.max_field;
      lines.push_back(images + " fit no lens: " +
                      (by_windows ? "their windows ask for different ones, " + host::brief(check.spread) +
                                        " times as far apart as errors explain. A rolling shutter on a vehicle that "
                                        "swings, or a zoom or focus that moved"
                                  : "in parts of the image the residuals stay " + host::brief(check.field) +
                                        " times as large as errors explain. Something has bent the images") +
                      "; stated errors are too small.");
    }
  }
  if (!lines.empty()) {
    lines.emplace_back(
        "What to do: check the camera file (size, focus, zoom), or measure the camera (ilp-lab calibrate-target).");
  }
  return lines;
}

}  // namespace

std::vector<std::string> camera_lines(const intake::Flight& flight) {
  std::vector<std::string> lines = not_found_lines(flight);
  for (std::string& line : contradiction_lines(flight)) lines.push_back(std::move(line));
  return lines;
}

}  // namespace ilp::report
