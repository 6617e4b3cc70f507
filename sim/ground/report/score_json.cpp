#include <nlohmann/json.hpp>

#include "sim/ground/report/json_parts.hpp"
#include "sim/host/metrics.hpp"

namespace ilp::report {
namespace {

using Json = nlohmann::ordered_json;

Json vector_json(const std::optional<Vec3>& v) {
  return v ? Json{v->x(), v->y(), v->z()} : Json(nullptr);
}

Json keyframe_json(const ScoredKeyframe& k) {
  return {{"id", k.id},
          {"distance", k.distance},
          {"position_error", k.position_error},
          {"height_error", k.height_error},
          {"drift_error", k.drift_error},
          {"local_scale", k.local_scale},
          {"true_centre", vector_json(k.true_centre)},
          {"aligned_centre", vector_json(k.aligned_centre)},
          {"sigma", vector_json(k.sigma)},
          {"relative_error", vector_json(k.relative_error)},
          {"overlap", k.overlap},
          {"true_overlap", k.true_overlap}};
}

Json list_json(const std::vector<ScoredKeyframe>& keyframes) {
  Json list = Json::array();
  for (const ScoredKeyframe& k : keyframes) list.push_back(keyframe_json(k));
  return list;
}

}  // namespace

Json score_json(const ScoreFile& score) {
  Json strips = Json::array(), scores = Json::array();
  for (const ScoredStrip& s : score.strips) {
    strips.push_back({{"id", s.id},
                      {"length", s.length},
                      {"position_mean_percent", s.position_mean_percent},
                      {"bow_fit", vector_json(s.bow_fit)},
                      {"up", vector_json(s.up)},
                      {"forward", vector_json(s.forward)},
                      {"keyframes", list_json(s.keyframes)},
                      {"surface_error", s.surface_error}});
  }
  for (const host::Metric& metric : host::metrics()) {
    if (*metric.group == '\0') continue;
    const auto found = score.summary.find(metric.key);
    scores.push_back({{"key", metric.key},
                      {"group", metric.group},
                      {"label", metric.label},
                      {"value", found == score.summary.end() ? Json(nullptr) : Json(found->second)},
                      {"perfect", metric.ideal}});
  }
  return {{"complete", score.complete}, {"target_overlap", score.target_overlap},  {"scores", scores},
          {"strips", strips},           {"keyframes", list_json(score.keyframes)}, {"remarks", score.remarks}};
}

}  // namespace ilp::report
