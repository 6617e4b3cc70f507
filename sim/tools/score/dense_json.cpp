#include "sim/tools/score/dense_json.hpp"

#include <cmath>

namespace ilp::score {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json errors_json(const ErrorPercent& e) {
  return {{"count", e.count},
          {"bias_percent", number(e.bias)},
          {"median_percent", number(e.median)},
          {"p95_percent", number(e.p95)}};
}

Json optional_errors(const std::optional<ErrorPercent>& e) {
  return e ? errors_json(*e) : Json(nullptr);
}

Json sigma_json(const SigmaShares& s) {
  return {{"count", s.count},
          {"within_1", number(s.within_1)},
          {"within_2", number(s.within_2)},
          {"normalised_error_squared", number(s.squared)},
          {"normalised_error_squared_robust", number(s.squared_robust)}};
}

Json depth_json(const DepthScore& d) {
  return {{"flying_height", number(d.flying_height)},
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
          {"precision", number(m.precision())},
          {"recall", number(m.recall())},
          {"double_coded_share", number(m.double_coded_share())},
          {"completeness", number(m.completeness())}};
}

Json quality_json(const QualityScore& q) {
  return {{"image_bytes", q.image_bytes},
          {"depth_bytes", q.depth_bytes},
          {"masked_px", q.masked_pixels},
          {"psnr_db", number(q.psnr_db())},
          {"lossless", q.compared_pixels > 0 && q.squares == 0},
          {"image_bytes_per_masked_px", number(q.image_bytes_per_masked_pixel())}};
}

Json overlap_json(const OverlapScore& o) {
  Json measured = Json::array(), achieved = Json::array();
  for (const MeasuredOverlap& m : o.measured) {
    measured.push_back({{"keyframe", m.keyframe},
                        {"frame", m.frame},
                        {"measured", number(m.measured)},
                        {"true_footprint", number(m.true_footprint)},
                        {"true", number(m.true_overlap)}});
  }
  for (const AchievedOverlap& a : o.achieved) {
    achieved.push_back({{"previous", a.previous_id}, {"keyframe", a.keyframe_id}, {"true", number(a.true_overlap)}});
  }
  return {{"target", number(o.target)},
          {"true_mean", number(o.true_mean)},
          {"true_std", number(o.true_std)},
          {"error_bias", number(o.error_bias)},
          {"error_median", number(o.error_median)},
          {"error_p95", number(o.error_p95)},
          {"measured", std::move(measured)},
          {"achieved", std::move(achieved)}};
}

Json strip_json(std::int64_t id, const StripDense& s) {
  Json json{{"id", id},
            {"flying_height", number(s.flying_height)},
            {"scale", number(s.aligned.true_from_strip.scale)},
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
                                    {"mask_precision", score.mask.precision()},
                                    {"mask_recall", score.mask.recall()},
                                    {"double_coded_share", score.mask.double_coded_share()},
                                    {"overlap_true_mean", score.overlap.true_mean},
                                    {"overlap_true_std", score.overlap.true_std},
                                    {"overlap_error_p95", score.overlap.error_p95},
                                    {"image_psnr_db", score.quality.psnr_db()},
                                    {"image_bytes_per_masked_pixel", score.quality.image_bytes_per_masked_pixel()}});
  return summary;
}

}  // namespace ilp::score
