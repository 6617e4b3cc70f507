#include "sim/ground/report/accuracy_summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <utility>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/report/camera_lines.hpp"
#include "sim/host/statistics.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

constexpr double degree = 180 / std::numbers::pi;

bool measurements_contradict(const intake::Strip& strip) {
  return strip.frame && strip.frame->verdict > StripFrameVerdict::nothing_measured;
}

std::string pose_verdict(const intake::Keyframe& keyframe) {
  if (!keyframe.pose) return "no pose received";
  return keyframe.pose->state == PoseState::failed ? words_of(keyframe.pose->verdict) : "pose still provisional";
}

/// Where a fourth or more of one kind of measurements contradicts the others.
void report_refused(const std::string& strip, const StripFrameRecord& frame, std::vector<std::string>& lines) {
  const auto add_measurements = [&](const char* kind, std::uint32_t used, std::uint32_t refused) {
    if (refused == 0 || 4 * refused < used + refused) return;
    lines.push_back(strip + ": " + std::to_string(refused) + " of " + std::to_string(used + refused) + " " + kind +
                    " contradict the others and are left out");
  };
  add_measurements("heights", frame.heights_used, frame.heights_refused);
  add_measurements("attitudes", frame.attitudes_used, frame.attitudes_refused);
  add_measurements("positions", frame.positions_used, frame.positions_refused);
  add_measurements("velocities", frame.velocities_used, frame.velocities_refused);
}

}  // namespace

std::string parts_text(const map::HeightErrorParts& parts, double factor) {
  const auto part = [factor](const char* name, double sigma) {
    return std::string(name) + " " + (sigma > 0 ? host::brief(factor * sigma) : "not known");
  };
  return part("matching", parts.matching) + ", " + part("poses", parts.poses) + ", " + part("scale", parts.scale) +
         ", " + part("tilt", parts.tilt) + ", " + part("place", parts.place);
}

AccuracySummary scored_accuracy(const ScoreFile& score) {
  const auto value = [&](const char* key) {
    const auto found = score.summary.find(key);
    return found == score.summary.end() ? unknown : found->second;
  };
  AccuracySummary accuracy;
  accuracy.mean_percent = value("position_mean_percent");
  accuracy.max_percent = value("position_max_percent");
  accuracy.rotation_deg = value("rotation_mean_deg");
  accuracy.height_percent = value("height_median_percent");
  accuracy.depth_percent = value("depth_median_percent");
  for (const ScoredKeyframe& k : score.keyframes) accuracy.poses += std::isfinite(k.position_error) ? 1U : 0U;
  return accuracy;
}

AccuracySummary measured_accuracy(const Report& report) {
  AccuracySummary accuracy;
  double length = 0, mean = 0, max = 0, rotations = 0;
  std::vector<double> depths;
  for (const StripResult& strip : report.strips) {
    if (!strip.accuracy) continue;
    const StripAccuracy& a = *strip.accuracy;
    if (a.poses >= fewest_poses && a.length > 0) {
      length += a.length;
      mean += a.position.mean;
      max += a.position.max;
      accuracy.poses += a.poses;
      rotations += degree * a.rotation_rad.mean * static_cast<double>(a.poses);
    }
    for (const auto& [id, keyframe] : a.keyframes) {
      if (keyframe.depth) depths.push_back(keyframe.depth->median_abs_percent);
    }
  }
  if (length > 0) {
    accuracy.mean_percent = 100 * mean / length;
    accuracy.max_percent = 100 * max / length;
    accuracy.rotation_deg = rotations / static_cast<double>(accuracy.poses);
  }
  if (!depths.empty()) accuracy.keyframe_depth_percent = host::median(std::move(depths));
  return accuracy;
}

bool model_is_measured(const Report& report) {
  return report.has_reference && !report.joined.models.empty() && std::isfinite(measured_accuracy(report).mean_percent);
}

std::vector<std::string> accuracy_lines(const Report& report) {
  std::vector<std::string> lines;
  const bool joined = model_is_measured(report);
  for (const StripResult& strip : report.strips) {
    if (!strip.accuracy) continue;
    const StripAccuracy& a = *strip.accuracy;
    const std::string foreign =
        foreign_reference(a.poses, degree * a.rotation_rad.mean, a.percent_of_length(a.position.mean));
    if (!foreign.empty()) lines.push_back("strip " + std::to_string(strip.strip.id) + ": " + foreign);
  }
  if (joined || (report.has_reference && !report.score)) {
    const AccuracySummary own = measured_accuracy(report);
    if (std::isfinite(own.mean_percent)) {
      lines.push_back(std::string("position error") + (joined ? " of the joined model" : "") + ": mean " +
                      host::brief(own.mean_percent) + " %, largest " + host::brief(own.max_percent) +
                      " % of the distance flown, " + host::counted(own.poses, "pose") + "; attitude error: mean " +
                      host::brief(own.rotation_deg) + " degrees");
    }
    if (joined && std::isfinite(own.keyframe_depth_percent)) {
      lines.push_back("depth error of the joined model: median keyframe " + host::brief(own.keyframe_depth_percent) +
                      " % of the flying height");
    }
  }
  if (!report.score) return lines;
  if (joined) lines.emplace_back("The strips as the flight sent them:");
  for (std::string& line : score_lines(*report.score)) lines.push_back((joined ? "  " : "") + std::move(line));
  return lines;
}

std::vector<std::string> estimated_error_lines(const Report& report) {
  constexpr std::size_t most_strips = 4;
  std::vector<std::string> lines;
  std::size_t reported = 0, without_metres = 0;
  for (const StripResult& strip : report.strips) {
    const std::string name = "strip " + std::to_string(strip.strip.id);
    if (measurements_contradict(strip.strip)) {
      lines.push_back(name +
                      ": the vehicle's measurements contradict each other: " + words_of(strip.strip.frame->verdict));
    }
    if (strip.strip.frame) report_refused(name, *strip.strip.frame, lines);
    if (!strip.grid) continue;
    const auto [factor, unit] = length_unit(report, strip);
    without_metres += unit == "m" ? 0 : 1;
    if (++reported > most_strips) continue;
    const map::HeightErrorParts& parts = strip.usual_errors;
    if (parts.whole() > 0) {
      lines.push_back("heights of " + name + ", estimated error (one sigma, median): " +
                      host::brief(factor * parts.whole()) + " " + unit + " of " + parts_text(parts, factor));
    }
  }
  if (reported > most_strips) lines.push_back("further strips: see the report");
  if (without_metres > 0) {
    lines.push_back(
        host::counted(without_metres, "strip") +
        " in units of the first baseline, not in metres: no altimeter, position or velocity was given "
        "(simulated: --set navigation.altimeter=true; own images: --navigation FILE, or heights in times.txt)");
  }
  return lines;
}

std::vector<std::string> nothing_lines(const Report& report) {
  const ReportTotals sums = totals(report);
  if (sums.posed > 0) return {};
  if (sums.keyframes == 0) {
    return {"Nothing is mapped: no keyframe has come down.",
            "What to do: check exposure, focus and texture of the images, and that they are of one camera; the events "
            "say what became of each."};
  }
  std::map<std::string, std::size_t> counts;
  for (const auto& [id, keyframe] : report.flight.keyframes) ++counts[pose_verdict(keyframe)];
  const auto most =
      std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  std::vector<std::string> lines = {"Nothing is mapped: " +
                                    (sums.keyframes == 1
                                         ? std::string("the only keyframe has no pose")
                                         : "none of the " + std::to_string(sums.keyframes) + " keyframes has a pose") +
                                    ". Why, of " + std::to_string(most->second) + " of them: " + most->first + "."};
  if (!camera_lines(report.flight).empty()) return lines;  // these say what to do
  lines.emplace_back(
      sums.keyframes == 1
          ? "What to do: let the camera move: one place seen twice has no baseline. Images of moving ground need 80 % "
            "of overlap with the one before."
          : "What to do: take images more often (80 % of overlap or more, at least 55 %), check exposure, focus and "
            "texture, and that the camera file is that of these images.");
  return lines;
}

}  // namespace ilp::report
