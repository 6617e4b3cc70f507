// Keyframes for the viewer: where they were taken, what they saw, what came down of them.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/ground/viewer/viewer_data.hpp"
#include "sim/host/files.hpp"
#include "sim/host/picture.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::viewer {
namespace {

using nlohmann::json;

const report::StripResult* strip_of(const report::Report& report, const intake::Keyframe& keyframe) {
  for (const report::StripResult& strip : report.strips) {
    if (strip.strip.id == keyframe.strip_id) return &strip;
  }
  return nullptr;
}

// Covariance of the centre, upper triangle row by row. Where it is unknown, the sigmas along the axes give the
// diagonal.
json centre_covariance(const PoseRecord& pose) {
  const double(&c)[21] = pose.covariance;
  if (c[9] > 0 && c[14] > 0 && c[20] > 0) return {c[9], c[13], c[18], c[14], c[19], c[20]};
  const double(&s)[3] = pose.sigma;
  return {s[0] * s[0], 0, 0, s[1] * s[1], 0, s[2] * s[2]};
}

json pose_facts(const PoseRecord& pose) {
  return {{"q", pose.q_cam_from_world},  {"centre", pose.centre},
          {"sigma", pose.sigma},         {"covariance", centre_covariance(pose)},
          {"rms_px", pose.rms_px},       {"matches", pose.matches},
          {"inliers", pose.inliers},     {"parallax_px", pose.parallax_px},
          {"min_depth", pose.min_depth}, {"max_depth", pose.max_depth}};
}

json product_facts(const intake::Keyframe& keyframe, ProductKind kind) {
  const std::optional<intake::ProductAccount>& account = keyframe.product(kind);
  const std::optional<ProductRecord>& record = keyframe.product_records[static_cast<std::size_t>(kind)];
  if (!account && !record) return nullptr;
  json facts = json::object();
  if (account) {
    facts = {{"file", account->file},
             {"bytes", account->bytes},
             {"grant_bytes", account->grant_bytes},
             {"scheme", words_of(account->scheme)},
             {"layers", account->layers}};
  }
  if (record) {
    facts["layers_made"] = record->layers;
    facts["priority"] = record->priority;
    facts["full_bytes"] = record->bytes;
    if (account && account->layers >= 1 && account->layers <= static_cast<int>(limits::max_quality_layers)) {
      facts["quality"] = record->layer_quality[account->layers - 1];
    }
  }
  return facts;
}

json thumbnails(const map::KeyframeQuickLook& quick_look) {
  json pictures = json::object();
  if (!quick_look.image.empty()) pictures["image"] = host::data_uri(quick_look.image);
  if (!quick_look.mask.empty()) pictures["mask"] = host::data_uri(quick_look.mask);
  if (!quick_look.depth.empty()) {
    pictures["depth"] = host::data_uri(quick_look.depth);
    pictures["depth_range"] = {quick_look.nearest, quick_look.farthest};
  }
  return pictures;
}

json camera_facts(const CameraModel& c) {
  json facts = {c.width, c.height};
  const CameraNumbers numbers = camera_numbers(c);
  for (const double number : numbers.span()) facts.push_back(number);
  return facts;
}

json outline_of(const std::vector<Vec3>& points) {
  json outline = json::array();
  for (const Vec3& point : points) {
    for (const double coordinate : point) outline.push_back(coordinate);
  }
  return outline;
}

}  // namespace

json viewer_keyframe(const report::Report& report, const intake::Keyframe& k) {
  json out = {{"id", k.id},
              {"strip", k.strip_id},
              {"name", k.name},
              {"verdict", report::keyframe_verdict(k)},
              {"camera", camera_facts(k.camera)},
              {"posed", k.posed()},
              {"image", product_facts(k, ProductKind::image)},
              {"depth", product_facts(k, ProductKind::depth)},
              {"files", host::six_digits(k.id)}};
  out["thumbnails"] = thumbnails(report::look_of(report, k.id));
  if (k.record) {
    out["time_s"] = static_cast<double>(k.record->time_ns) / 1e9;
    out["frame"] = k.record->frame_id;
    out["altitude"] = k.record->altitude;
    if (k.record->index > 0) out["overlap"] = k.record->overlap;
  }
  if (k.posed()) out["pose"] = pose_facts(*k.pose);
  if (k.richness) {
    out["richness"] = k.richness->richness;
    out["novelty"] = k.richness->novelty;
    out["relief"] = k.richness->relief;
  }
  const double pixels = static_cast<double>(k.camera.width) * k.camera.height;
  if (k.mask_record && pixels > 0) out["newly_seen"] = k.mask_record->newly_seen / pixels;
  if (const report::StripResult* strip = strip_of(report, k))
    out["footprint"] = outline_of(exports::footprint_of(k, *strip));
  return out;
}

}  // namespace ilp::viewer
