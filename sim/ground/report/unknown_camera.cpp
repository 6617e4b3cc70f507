#include "sim/ground/report/unknown_camera.hpp"

#include <map>

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

}  // namespace

std::vector<std::string> unknown_camera_lines(const intake::Flight& flight) {
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

}  // namespace ilp::report
