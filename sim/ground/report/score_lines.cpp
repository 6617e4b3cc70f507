#include "sim/ground/report/score_lines.hpp"

#include <cmath>

#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

double value_of(const ScoreFile& score, const char* key) {
  const auto found = score.summary.find(key);
  return found == score.summary.end() ? unknown : found->second;
}

std::string percent(double share) {
  return host::fixed(100 * share, 0) + " %";
}

}  // namespace

std::vector<std::string> score_lines(const ScoreFile& score) {
  const auto value = [&](const char* key) { return value_of(score, key); };
  std::vector<std::string> lines;
  if (!score.complete) lines.emplace_back("the flight is not complete; it is scored as far as it went");
  if (std::isfinite(value("position_mean_percent"))) {
    lines.push_back("position error: mean " + host::brief(value("position_mean_percent")) + " %, largest " +
                    host::brief(value("position_max_percent")) + " % of the distance flown; attitude error: mean " +
                    host::brief(value("rotation_mean_deg")) + " degrees");
  }
  if (std::isfinite(value("height_median_percent"))) {
    lines.push_back("height error: median " + host::brief(value("height_median_percent")) + " %, 95 % below " +
                    host::brief(value("height_p95_percent")) + " % of the flying height; depth on " +
                    percent(value("completeness")) + " of the new ground");
  }
  if (std::isfinite(value("sigma1_share"))) {
    std::string line =
        "within the stated sigma (68 % would be honest): " + percent(value("sigma1_share")) + " of the position errors";
    if (std::isfinite(value("depth_sigma1_share")))
      line += ", " + percent(value("depth_sigma1_share")) + " of the depth errors";
    lines.push_back(line);
  }
  return lines;
}

}  // namespace ilp::report
