#include "sim/tools/score/score_json.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string_view>

#include "sim/host/metrics.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::score {
namespace {

// Numbers that are not finite are written as null.
using Json = nlohmann::ordered_json;

Json errors_json(const ErrorPercent& e) {
  return {{"count", e.count}, {"bias_percent", e.bias}, {"median_percent", e.median}, {"p95_percent", e.p95}};
}

Json optional_errors(const std::optional<ErrorPercent>& e) {
  return e ? errors_json(*e) : Json(nullptr);
}

Json sigma_json(const SigmaShares& s) {
  return {{"count", s.count},
          {"within_1", s.within_1},
          {"within_2", s.within_2},
          {"normalised_error_squared", s.squared},
          {"normalised_error_squared_robust", s.squared_robust}};
}

Json depth_json(const DepthScore& d) {
  return {{"flying_height", d.flying_height},
          {"strip_scale", errors_json(d.strip_scale)},
          {"metric_scale", optional_errors(d.metric_scale)},
          {"own_scale", errors_json(d.own_scale)},
          {"height", errors_json(d.height)},
          {"sigma", sigma_json(d.sigma)},
          {"own_scale_sigma", sigma_json(d.own_sigma)},
          {"sigma_with_poses", sigma_json(d.sigma_with_poses)}};
}

Json mask_json(const MaskScore& m) {
  return {{"masked_px", m.masked},
          {"newly_seen_px", m.newly_seen},
          {"precision", m.precision()},
          {"recall", m.recall()},
          {"double_coded_share", m.double_coded_share()},
          {"bytes", m.bytes},
          {"bytes_again", m.bytes_again},
          {"completeness", m.completeness()}};
}

Json quality_json(const QualityScore& q) {
  return {{"image_bytes", q.image_bytes},
          {"depth_bytes", q.depth_bytes},
          {"masked_px", q.masked_pixels},
          {"psnr_db", q.psnr_db()},
          {"lossless", q.compared_pixels > 0 && q.squares == 0},
          {"image_bytes_per_masked_px", q.image_bytes_per_masked_pixel()}};
}

/// A count of what the truth knows; unknown if it knows nothing.
double of_any(std::size_t known, std::size_t count) {
  return known == 0 ? unknown : static_cast<double>(count);
}

Json links_json(const LinkScore& l) {
  return {{"keyframes_that_return", l.returned},
          {"keyframes_linked", l.linked},
          {"pairs", l.pairs},
          {"pairs_linked", l.pairs_linked},
          {"links", l.links},
          {"false_links", l.false_links}};
}

Json overlap_json(const OverlapScore& o) {
  Json measured = Json::array(), achieved = Json::array();
  for (const MeasuredOverlap& m : o.measured) {
    measured.push_back({{"keyframe", m.keyframe},
                        {"frame", m.frame},
                        {"measured", m.measured},
                        {"true_footprint", m.true_footprint},
                        {"true", m.true_overlap}});
  }
  for (const AchievedOverlap& a : o.achieved) {
    achieved.push_back({{"previous", a.previous_id}, {"keyframe", a.keyframe_id}, {"true", a.true_overlap}});
  }
  return {{"target", o.target},
          {"true_mean", o.true_mean},
          {"true_std", o.true_std},
          {"error_bias", o.error_bias},
          {"error_median", o.error_median},
          {"error_p95", o.error_p95},
          {"measured", std::move(measured)},
          {"achieved", std::move(achieved)}};
}

Json strip_json(std::int64_t id, const StripDense& s) {
  Json json{{"id", id},
            {"flying_height", s.flying_height},
            {"scale", s.aligned.true_from_strip.scale},
            {"metric", s.aligned.true_from_metric_strip.has_value()},
            {"height", nullptr},
            {"metric_height", nullptr},
            {"covered_cells", nullptr},
            {"profile", Json::array()}};
  if (!s.height) return json;
  json["height"] = errors_json(s.height->error);
  json["metric_height"] = optional_errors(s.height->metric);
  json["covered_cells"] = s.height->covered;
  for (const HeightProfilePoint& p : s.height->profile) {
    json["profile"].push_back({{"distance", p.distance}, {"error", p.error}, {"cells", p.cells}});
  }
  return json;
}

Json keyframe_json(std::int64_t id, const KeyframeDense& k) {
  return {{"id", id},
          {"strip", k.strip_id},
          {"depth", k.depth ? depth_json(*k.depth) : Json(nullptr)},
          {"mask", k.mask ? mask_json(*k.mask) : Json(nullptr)},
          {"quality", k.quality ? quality_json(*k.quality) : Json(nullptr)}};
}

Json triple(const Vec3& v) {
  return {v[0], v[1], v[2]};
}

Json errors_json(const host::ErrorSummary& errors, double length) {
  const double percent = length > 0 ? 100 / length : std::numeric_limits<double>::quiet_NaN();
  return {{"count", errors.count},
          {"mean", errors.mean},
          {"rms", errors.rms},
          {"median", errors.median},
          {"max", errors.max},
          {"mean_percent", errors.mean * percent},
          {"max_percent", errors.max * percent}};
}

Json sigmas_json(const SigmaScore& s) {
  return {{"components", s.components},
          {"share_within_one", s.share_within_one()},
          {"share_within_two", s.share_within_two()},
          {"normalised_error_squared", s.normalised_error_squared()}};
}

Json rotation_json(const PoseScore& poses) {
  std::vector<double> angles;
  for (const double angle : poses.rotation_rad) angles.push_back(degrees * angle);
  const host::ErrorSummary errors = host::summarise(angles);
  return {{"mean", errors.mean}, {"median", errors.median}, {"max", errors.max}};
}

Json strip_json(const StripScore& s) {
  Json json = {{"id", s.id},
               {"keyframes", s.keyframes},
               {"posed", s.posed},
               {"scored", s.track.samples.size()},
               {"metric", s.track.metric},
               {"length", s.length},
               {"flying_height", s.track.flying_height > 0 ? Json(s.track.flying_height) : Json(nullptr)},
               {"true_per_strip_unit", s.poses ? Json(s.poses->true_from_strip.scale) : Json(nullptr)},
               {"position", s.poses ? errors_json(s.poses->position, s.length) : Json(nullptr)},
               {"position_rigid",
                s.poses && s.poses->position_rigid ? errors_json(*s.poses->position_rigid, s.length) : Json(nullptr)},
               {"rotation_deg", s.poses ? rotation_json(*s.poses) : Json(nullptr)},
               {"up", nullptr},
               {"forward", nullptr},
               {"drift", nullptr},
               {"scale_drift_percent", s.scale_drift ? Json(s.scale_drift->percent) : Json(nullptr)},
               {"bow", nullptr},
               {"sigmas", sigmas_json(s.sigmas)}};
  if (s.poses) {
    const TrackAxes axes = track_axes(s.track);
    json["up"] = triple(axes.up);
    json["forward"] = triple(axes.forward);
  }
  if (s.drift) {
    json["drift"] = {{"aligned_keyframes", s.drift->aligned_samples},
                     {"end_error", s.drift->end_error},
                     {"percent", s.drift->percent}};
  }
  if (s.bow) {
    json["bow"] = {{"sagitta", s.bow->sagitta}, {"percent", s.bow->percent}, {"fit", s.bow->fit}};
  }
  return json;
}

void add_sample(const StripScore& s, std::size_t i, Json& json) {
  const PoseSample& sample = s.track.samples[i];
  json["true_centre"] = triple(sample.true_centre);
  if (!s.poses) return;
  json["distance"] = s.poses->distance[i];
  json["aligned_centre"] = triple(sample.true_centre + s.poses->error[i]);
  json["position_error"] = s.poses->error[i].norm();
  json["rotation_error_deg"] = degrees * s.poses->rotation_rad[i];
  if (s.bow) json["height_error"] = s.bow->height_error[i];
  if (s.drift) json["drift_error"] = s.drift->error[i].norm();
  if (s.scale_drift && s.scale_drift->local_scale[i] > 0) json["local_scale"] = s.scale_drift->local_scale[i];
  const auto relative = s.sigmas.error.find(sample.keyframe_id);
  if (relative == s.sigmas.error.end()) return;
  const double scale = s.poses->true_from_strip.scale;
  json["sigma"] = triple(scale * sample.sigma);
  json["relative_error"] = triple(scale * relative->second);
}

Json keyframe_json(const intake::Keyframe& k) {
  Json json = {{"id", k.id}, {"strip", k.strip_id}, {"name", k.name}, {"posed", k.posed()}};
  json["frame"] = k.record ? Json(k.record->frame_id) : Json(nullptr);
  json["overlap"] = k.record && k.record->index > 0 ? Json(k.record->overlap) : Json(nullptr);
  for (const char* key : {"distance", "true_centre", "aligned_centre", "position_error", "height_error",
                          "rotation_error_deg", "drift_error", "local_scale", "sigma", "relative_error"}) {
    json[key] = nullptr;
  }
  return json;
}

}  // namespace

nlohmann::ordered_json dense_json(const DenseScore& score) {
  Json strips = Json::array(), keyframes = Json::array();
  for (const auto& [id, strip] : score.strips) strips.push_back(strip_json(id, strip));
  for (const auto& [id, keyframe] : score.keyframes) keyframes.push_back(keyframe_json(id, keyframe));
  return {{"depth", depth_json(score.depth)},
          {"height", errors_json(score.height)},
          {"metric_height", optional_errors(score.metric_height)},
          {"mask", mask_json(score.mask)},
          {"quality", quality_json(score.quality)},
          {"overlap", overlap_json(score.overlap)},
          {"links", links_json(score.links)},
          {"strips", std::move(strips)},
          {"keyframes", std::move(keyframes)},
          {"remarks", score.remarks}};
}

std::map<std::string, double> dense_summary(const DenseScore& score) {
  std::map<std::string, double> summary = ground_value_summary(score.value.value_or(GroundValue{}));
  summary.merge(
      std::map<std::string, double>{{"height_bias_percent", score.height.bias},
                                    {"height_median_percent", score.height.median},
                                    {"height_p95_percent", score.height.p95},
                                    {"depth_median_percent", score.depth.strip_scale.median},
                                    {"depth_p95_percent", score.depth.strip_scale.p95},
                                    {"completeness", score.mask.completeness()},
                                    {"depth_sigma1_share", score.depth.sigma.within_1},
                                    {"depth_sigma2_share", score.depth.sigma.within_2},
                                    {"depth_nes", score.depth.sigma.squared},
                                    {"depth_pose_sigma1_share", score.depth.sigma_with_poses.within_1},
                                    {"depth_pose_sigma2_share", score.depth.sigma_with_poses.within_2},
                                    {"track_mapped_share", score.track.mapped_share()},
                                    {"track_depth_median_percent", score.track.error_median_percent},
                                    {"landing_sampling_ratio", score.track.landing_ratio},
                                    {"mask_precision", score.mask.precision()},
                                    {"mask_recall", score.mask.recall()},
                                    {"double_coded_share", score.mask.double_coded_share()},
                                    {"bytes_again_share", score.mask.bytes_again_share()},
                                    {"keyframes_that_return", of_any(score.links.keyframes, score.links.returned)},
                                    {"linked_share", score.links.linked_share()},
                                    {"pairs_linked_share", score.links.pairs_linked_share()},
                                    {"false_links", of_any(score.links.keyframes, score.links.false_links)},
                                    {"overlap_true_mean", score.overlap.true_mean},
                                    {"overlap_true_std", score.overlap.true_std},
                                    {"overlap_error_p95", score.overlap.error_p95},
                                    {"image_psnr_db", score.quality.psnr_db()},
                                    {"image_bytes_per_masked_pixel", score.quality.image_bytes_per_masked_pixel()}});
  return summary;
}

Json score_json(const Score& score, const FlightFiles& files) {
  Json json = {{"version", score_version},
               {"complete", score.complete},
               {"frames", score.frames},
               {"keyframes_count", score.keyframes},
               {"posed", score.posed},
               {"strips_count", score.strips.size()},
               {"target_overlap", score.target_overlap}};
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
    if (found != summary.end()) json[row.key] = found->second;
  }
  for (const auto& [key, value] : summary) {
    if (!json.contains(key)) json[key] = value;
  }
  return json;
}

void write_table(const Score& score, const std::map<std::string, double>& summary, std::ostream& out) {
  std::size_t wide = 0;
  for (const host::Metric& row : host::metrics()) wide = std::max(wide, std::string_view(row.label).size() + 1);
  out << std::string(wide, ' ') << "score     perfect\n";
  for (const host::Metric& row : host::metrics()) {
    const auto found = summary.find(row.key);
    if (found == summary.end() || *row.group == '\0') continue;
    std::string label = row.label, value = std::isfinite(found->second) ? host::score_text(found->second) : "-";
    label.resize(wide, ' ');
    value.resize(10, ' ');
    if (*row.ideal == '\0') value.erase(value.find_last_not_of(' ') + 1);
    out << label << value << row.ideal << "\n";
  }
  if (!score.complete) out << "The flight is not complete; it is scored as far as it went.\n";
  for (const std::string& remark : score.remarks) out << "remark: " << remark << "\n";
}

}  // namespace ilp::score
