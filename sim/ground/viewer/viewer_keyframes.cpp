// Makes the viewer's data of keyframes: their poses, the ground that they show, and the data that came down.
#include <nlohmann/json.hpp>

#include "sim/ground/viewer/viewer_data.hpp"
#include "sim/host/picture.hpp"

namespace ilp::viewer {
namespace {

using json = nlohmann::ordered_json;

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

/// Null where no record of it came.
json made_of(const intake::Keyframe& keyframe, ProductKind kind) {
  const std::optional<intake::ProductAccount>& account = keyframe.product(kind);
  const std::optional<ProductRecord>& record = keyframe.product_records[static_cast<std::size_t>(kind)];
  if (!record) return nullptr;
  json made = {{"layers_made", record->layers}};
  if (account && account->layers >= 1 && account->layers <= static_cast<int>(limits::max_quality_layers)) {
    made["quality"] = record->layer_quality[account->layers - 1];
  }
  return made;
}

json thumbnails(const map::KeyframeQuickLook& quick_look) {
  json pictures = json::object();
  if (!quick_look.image.empty()) pictures["image"] = host::data_uri(quick_look.image);
  if (!quick_look.mask.empty()) pictures["mask"] = host::data_uri(quick_look.mask);
  if (!quick_look.depth.empty()) pictures["depth"] = host::data_uri(quick_look.depth);
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
  json out = {{"camera", camera_facts(k.camera)},
              {"image", made_of(k, ProductKind::image)},
              {"depth", made_of(k, ProductKind::depth)},
              {"thumbnails", thumbnails(report::look_of(report, k.id))}};
  if (k.posed()) out["covariance"] = centre_covariance(*k.pose);
  if (const report::StripResult* strip = strip_of(report, k))
    out["footprint"] = outline_of(exports::footprint_of(k, *strip));
  return out;
}

}  // namespace ilp::viewer
