#include "sim/ground/report/score_file.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>

#include "sim/host/files.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

using ScoreJson = nlohmann::json;
constexpr int known_version = 1;

const ScoreJson& member(const ScoreJson& json, const char* key) {
  static const ScoreJson absent;
  if (!json.is_object()) return absent;
  const auto found = json.find(key);
  return found == json.end() ? absent : *found;
}

double number(const ScoreJson& json, const char* key) {
  const ScoreJson& value = member(json, key);
  return value.is_number() ? value.get<double>() : unknown;
}

std::int64_t whole(const ScoreJson& json, const char* key) {
  const ScoreJson& value = member(json, key);
  return value.is_number_integer() ? value.get<std::int64_t>() : 0;
}

std::optional<Vec3> triple(const ScoreJson& json, const char* key) {
  const ScoreJson& value = member(json, key);
  if (!value.is_array() || value.size() != 3) return std::nullopt;
  Vec3 v;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!value[i].is_number()) return std::nullopt;
    v[static_cast<Eigen::Index>(i)] = value[i].get<double>();
  }
  return v;
}

ScoredKeyframe keyframe_of(const ScoreJson& json) {
  ScoredKeyframe k;
  k.id = whole(json, "id");
  k.distance = number(json, "distance");
  k.position_error = number(json, "position_error");
  k.height_error = number(json, "height_error");
  k.drift_error = number(json, "drift_error");
  k.local_scale = number(json, "local_scale");
  k.true_centre = triple(json, "true_centre");
  k.aligned_centre = triple(json, "aligned_centre");
  k.sigma = triple(json, "sigma");
  k.relative_error = triple(json, "relative_error");
  k.overlap = number(json, "overlap");
  return k;
}

ScoredStrip strip_of(const ScoreJson& json) {
  ScoredStrip s;
  s.id = whole(json, "id");
  s.length = number(json, "length");
  s.flying_height = number(json, "flying_height");
  s.position_mean_percent = number(member(json, "position"), "mean_percent");
  s.position_max_percent = number(member(json, "position"), "max_percent");
  s.drift_percent = number(member(json, "drift"), "percent");
  s.scale_drift_percent = number(json, "scale_drift_percent");
  const ScoreJson& bow = member(json, "bow");
  s.bow_percent = number(bow, "percent");
  s.bow_fit = triple(bow, "fit");
  s.up = triple(json, "up");
  s.forward = triple(json, "forward");
  return s;
}

void read_dense(const ScoreJson& dense, ScoreFile& score) {
  std::map<std::int64_t, double> overlaps;
  for (const ScoreJson& achieved : member(member(dense, "overlap"), "achieved")) {
    overlaps[whole(achieved, "keyframe")] = number(achieved, "true");
  }
  for (ScoredKeyframe& keyframe : score.keyframes) {
    const auto found = overlaps.find(keyframe.id);
    if (found != overlaps.end()) keyframe.true_overlap = found->second;
  }
  for (const ScoreJson& json : member(dense, "strips")) {
    for (ScoredStrip& strip : score.strips) {
      if (strip.id != whole(json, "id")) continue;
      for (const ScoreJson& point : member(json, "profile")) {
        strip.surface_error.emplace_back(number(point, "distance"), number(point, "error"));
      }
    }
  }
}

void read_keyframes(const ScoreJson& json, ScoreFile& score) {
  for (const ScoreJson& entry : member(json, "keyframes")) {
    const ScoredKeyframe keyframe = keyframe_of(entry);
    score.keyframes.push_back(keyframe);
    for (ScoredStrip& strip : score.strips) {
      if (strip.id == whole(entry, "strip") && keyframe.true_centre) strip.keyframes.push_back(keyframe);
    }
  }
}

host::Raster<float> read_height_error(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) ? host::read_pfm(path) : host::Raster<float>();
}

double value_of(const ScoreFile& score, const char* key) {
  const auto found = score.summary.find(key);
  return found == score.summary.end() ? unknown : found->second;
}

std::string percent(double share) {
  return host::fixed(100 * share, 0) + " %";
}

}  // namespace

ScoreFile read_score(const std::filesystem::path& path) {
  const ScoreJson json = ScoreJson::parse(host::read_file(path), nullptr, false);
  if (!member(json, "summary").is_object() || whole(json, "version") != known_version) {
    throw std::runtime_error(path.string() + " is no score that this program can read: expected JSON of version " +
                             std::to_string(known_version) + ", as ilp-score writes it");
  }
  ScoreFile score;
  const ScoreJson& complete = member(json, "complete");
  score.complete = complete.is_boolean() && complete.get<bool>();
  score.target_overlap = number(json, "target_overlap");
  for (const auto& [key, value] : member(json, "summary").items()) {
    score.summary[key] = value.is_number() ? value.get<double>() : unknown;
  }
  for (const ScoreJson& strip : member(json, "strips")) score.strips.push_back(strip_of(strip));
  read_keyframes(json, score);
  read_dense(member(json, "dense"), score);
  for (const ScoreJson& remark : member(json, "remarks")) {
    if (remark.is_string()) score.remarks.push_back(remark.get<std::string>());
  }
  score.height_error = read_height_error(path.parent_path() / "height-error.pfm");
  return score;
}

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
    std::string line = "within the estimated sigma (68 % would be honest): " + percent(value("sigma1_share")) +
                       " of the position errors";
    if (std::isfinite(value("depth_sigma1_share")))
      line += ", " + percent(value("depth_sigma1_share")) + " of the depth errors";
    lines.push_back(line);
  }
  return lines;
}

}  // namespace ilp::report
