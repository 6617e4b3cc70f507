#include "sim/tools/score/score_json.hpp"

#include <cmath>
#include <ostream>

#include "sim/host/metrics.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::score {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json triple(const Vec3& v) {
  return {number(v[0]), number(v[1]), number(v[2])};
}

Json errors_json(const host::ErrorSummary& errors, double length) {
  const double percent = length > 0 ? 100 / length : std::numeric_limits<double>::quiet_NaN();
  return {{"count", errors.count},
          {"mean", number(errors.mean)},
          {"rms", number(errors.rms)},
          {"median", number(errors.median)},
          {"max", number(errors.max)},
          {"mean_percent", number(errors.mean * percent)},
          {"max_percent", number(errors.max * percent)}};
}

Json sigmas_json(const SigmaScore& s) {
  return {{"components", s.components},
          {"share_within_one", number(s.share_within_one())},
          {"share_within_two", number(s.share_within_two())},
          {"normalised_error_squared", number(s.normalised_error_squared())}};
}

Json rotation_json(const PoseScore& poses) {
  std::vector<double> angles;
  for (const double angle : poses.rotation_rad) angles.push_back(degrees * angle);
  const host::ErrorSummary errors = host::summarise(angles);
  return {{"mean", number(errors.mean)}, {"median", number(errors.median)}, {"max", number(errors.max)}};
}

Json strip_json(const StripScore& s) {
  Json json = {{"id", s.id},
               {"keyframes", s.keyframes},
               {"posed", s.posed},
               {"scored", s.track.samples.size()},
               {"metric", s.track.metric},
               {"length", number(s.length)},
               {"flying_height", s.track.flying_height > 0 ? number(s.track.flying_height) : Json(nullptr)},
               {"true_per_strip_unit", s.poses ? number(s.poses->true_from_strip.scale) : Json(nullptr)},
               {"position", s.poses ? errors_json(s.poses->position, s.length) : Json(nullptr)},
               {"position_rigid",
                s.poses && s.poses->position_rigid ? errors_json(*s.poses->position_rigid, s.length) : Json(nullptr)},
               {"rotation_deg", s.poses ? rotation_json(*s.poses) : Json(nullptr)},
               {"up", nullptr},
               {"forward", nullptr},
               {"drift", nullptr},
               {"scale_drift_percent", s.scale_drift ? number(s.scale_drift->percent) : Json(nullptr)},
               {"bow", nullptr},
               {"sigmas", sigmas_json(s.sigmas)}};
  if (s.poses) {
    const TrackAxes axes = track_axes(s.track);
    json["up"] = triple(axes.up);
    json["forward"] = triple(axes.forward);
  }
  if (s.drift) {
    json["drift"] = {{"aligned_keyframes", s.drift->aligned_samples},
                     {"end_error", number(s.drift->end_error)},
                     {"percent", number(s.drift->percent)}};
  }
  if (s.bow) {
    json["bow"] = {{"sagitta", number(s.bow->sagitta)},
                   {"percent", number(s.bow->percent)},
                   {"fit", {number(s.bow->fit[0]), number(s.bow->fit[1]), number(s.bow->fit[2])}}};
  }
  return json;
}

void add_sample(const StripScore& s, std::size_t i, Json& json) {
  const PoseSample& sample = s.track.samples[i];
  json["true_centre"] = triple(sample.true_centre);
  if (!s.poses) return;
  json["distance"] = number(s.poses->distance[i]);
  json["aligned_centre"] = triple(sample.true_centre + s.poses->error[i]);
  json["position_error"] = number(s.poses->error[i].norm());
  json["rotation_error_deg"] = number(degrees * s.poses->rotation_rad[i]);
  if (s.bow) json["height_error"] = number(s.bow->height_error[i]);
  if (s.drift) json["drift_error"] = number(s.drift->error[i].norm());
  if (s.scale_drift && s.scale_drift->local_scale[i] > 0) json["local_scale"] = number(s.scale_drift->local_scale[i]);
  const auto relative = s.sigmas.error.find(sample.keyframe_id);
  if (relative == s.sigmas.error.end()) return;
  const double scale = s.poses->true_from_strip.scale;
  json["sigma"] = triple(scale * sample.sigma);
  json["relative_error"] = triple(scale * relative->second);
}

Json keyframe_json(const intake::Keyframe& k) {
  Json json = {{"id", k.id}, {"strip", k.strip_id}, {"name", k.name}, {"posed", k.posed()}};
  json["frame"] = k.record ? Json(k.record->frame_id) : Json(nullptr);
  json["overlap"] = k.record && k.record->index > 0 ? number(k.record->overlap) : Json(nullptr);
  for (const char* key : {"distance", "true_centre", "aligned_centre", "position_error", "height_error",
                          "rotation_error_deg", "drift_error", "local_scale", "sigma", "relative_error"}) {
    json[key] = nullptr;
  }
  return json;
}

}  // namespace

Json score_json(const Score& score, const FlightFiles& files) {
  Json json = {{"version", score_version},
               {"complete", score.complete},
               {"frames", score.frames},
               {"keyframes_count", score.keyframes},
               {"posed", score.posed},
               {"strips_count", score.strips.size()},
               {"target_overlap", number(score.target_overlap)}};
  json["strips"] = Json::array();
  std::map<std::int64_t, Json> keyframes;
  for (const auto& [id, keyframe] : files.flight.keyframes) keyframes[id] = keyframe_json(keyframe);
  for (const StripScore& strip : score.strips) {
    json["strips"].push_back(strip_json(strip));
    for (std::size_t i = 0; i < strip.track.samples.size(); ++i) {
      add_sample(strip, i, keyframes[strip.track.samples[i].keyframe_id]);
    }
  }
  json["keyframes"] = Json::array();
  for (const auto& [id, keyframe] : keyframes) json["keyframes"].push_back(keyframe);
  json["remarks"] = score.remarks;
  return json;
}

Json summary_json(const std::map<std::string, double>& summary) {
  Json json = Json::object();
  for (const host::Metric& row : host::metrics()) {
    const auto found = summary.find(row.key);
    if (found != summary.end()) json[row.key] = number(found->second);
  }
  for (const auto& [key, value] : summary) {
    if (!json.contains(key)) json[key] = number(value);
  }
  return json;
}

void write_table(const Score& score, const std::map<std::string, double>& summary, std::ostream& out) {
  out << std::string(48, ' ') << "score     perfect\n";
  for (const host::Metric& row : host::metrics()) {
    const auto found = summary.find(row.key);
    if (found == summary.end() || *row.group == '\0') continue;
    std::string label = row.label, value = std::isfinite(found->second) ? host::score_text(found->second) : "-";
    label.resize(48, ' ');
    value.resize(10, ' ');
    if (*row.ideal == '\0') value.erase(value.find_last_not_of(' ') + 1);
    out << label << value << row.ideal << "\n";
  }
  if (!score.complete) out << "The flight is not complete; it is scored as far as it went.\n";
  for (const std::string& remark : score.remarks) out << "remark: " << remark << "\n";
}

}  // namespace ilp::score
