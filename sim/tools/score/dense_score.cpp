#include "sim/tools/score/dense_score.hpp"

#include <exception>
#include <limits>
#include <system_error>

#include "sim/ground/map/strip_map.hpp"
#include "sim/host/statistics.hpp"
#include "sim/tools/score/calibration_score.hpp"

namespace ilp::score {
namespace {

class DenseScorer {
 public:
  DenseScorer(const intake::Flight& flight, const report::Reference& reference, const CameraModel& camera,
              const DenseOptions& options)
      : flight_(flight), options_(options), truth_(reference, camera) {
    if (options.truth.empty()) return;
    try {
      heights_ = world::read_height_grid(options.truth);
    } catch (const std::exception& fault) {
      score_.remarks.emplace_back(fault.what());
    }
  }

  DenseScore run() {
    score_all_masks();
    for (const auto& [id, strip] : flight_.strips) score_surface_of(strip);
    score_.depth = depth_score(all_);
    score_.depth.flying_height = host::median(flying_heights_);
    score_.height = error_percent(all_heights_);
    if (!metric_heights_.empty()) score_.metric_height = error_percent(metric_heights_);
    for (const auto& [id, quality] : score_quality(flight_, options_.images, score_.remarks)) {
      keyframe(id).quality = quality;
      score_.quality.add(quality);
    }
    score_.overlap = score_overlaps(flight_, options_.target_overlap, truth_);
    score_.links = score_links(flight_, links_of(flight_), truth_);
    std::map<std::int64_t, AlignedStrip> aligned;
    for (const auto& [id, strip] : score_.strips) aligned[id] = strip.aligned;
    score_.track = score_track(flight_, aligned, truth_);
    score_value();
    return std::move(score_);
  }

 private:
  KeyframeDense& keyframe(std::int64_t id) {
    KeyframeDense& k = score_.keyframes[id];
    k.strip_id = flight_.keyframes.at(id).strip_id;
    return k;
  }

  void score_all_masks() {
    for (const auto& [id, mask] : score_masks(flight_, truth_)) {
      keyframe(id).mask = mask;
      score_.mask.add(mask);
    }
  }

  /// With a pose and after this one, up to its partner; none when the partner is not known.
  std::vector<const intake::Keyframe*> keyframes_to_partner(const intake::Keyframe& keyframe) const {
    const std::int64_t partner = keyframe.depth ? keyframe.depth->partner_id : 0;
    std::vector<const intake::Keyframe*> keyframes;
    for (auto k = flight_.keyframes.upper_bound(keyframe.id); k != flight_.keyframes.end() && k->first <= partner;
         ++k) {
      if (k->second.posed() && k->second.strip_id == keyframe.strip_id) keyframes.push_back(&k->second);
    }
    return keyframes.empty() || keyframes.back()->id != partner ? std::vector<const intake::Keyframe*>{} : keyframes;
  }

  double flying_height_of(const intake::Strip& strip) {
    std::vector<double> depths;
    for (const std::int64_t id : strip.keyframes) {
      const world::TrueFrame* frame = truth_.sampled(flight_.keyframes.at(id).name);
      if (frame == nullptr) continue;
      std::vector<double> own;
      for (const float z : frame->depth) {
        if (z > 0 && z < std::numeric_limits<float>::infinity()) own.push_back(z);
      }
      if (!own.empty()) depths.push_back(host::median(std::move(own)));
    }
    return host::median(std::move(depths));
  }

  void score_surface_of(const intake::Strip& strip) {
    const double flying_height = flying_height_of(strip);
    if (!(flying_height > 0)) return;
    auto aligned = align_strip(flight_, strip, truth_.reference(), flying_height);
    if (!aligned) return;
    flying_heights_.push_back(flying_height);
    for (const std::int64_t id : aligned->keyframes) {
      const intake::Keyframe& k = flight_.keyframes.at(id);
      const auto whole = k.inverse_depth.empty() ? std::nullopt : truth_.whole(k.name);
      if (!whole) continue;
      const DepthErrors errors = depth_errors(k, keyframes_to_partner(k), *whole, *aligned, rays_);
      if (errors.strip_scale.empty()) continue;
      keyframe(id).depth = depth_score(errors);
      all_.append(errors);
    }
    StripDense& result = score_.strips[strip.id];
    result.aligned = std::move(*aligned);
    result.flying_height = flying_height;
    score_heights_of(strip, result);
  }

  void score_heights_of(const intake::Strip& strip, StripDense& result) {
    if (!heights_) return;
    const auto grid = map::build_grid(flight_, strip, {});
    if (!grid) return;
    std::vector<Vec3> centres;
    for (const std::int64_t id : result.aligned.keyframes) {
      centres.push_back(truth_.reference().pose(flight_.keyframes.at(id).name)->centre);
    }
    result.height = score_heights(*grid, result.aligned, *heights_, centres, result.flying_height);
    all_heights_.insert(all_heights_.end(), result.height->percent.begin(), result.height->percent.end());
    metric_heights_.insert(metric_heights_.end(), result.height->metric_percent.begin(),
                           result.height->metric_percent.end());
  }

  void score_value() {
    if (!heights_) return;
    std::vector<StripErrors> strips;
    for (const auto& [id, strip] : score_.strips) {
      if (strip.height && !strip.height->error_map.empty()) {
        strips.push_back({&strip.height->error_map, strip.flying_height});
      }
    }
    score_.value = score_ground(*heights_, strips);
    try {
      const std::vector<world::PlantedFeature> features = planted_features(options_.truth, *heights_);
      score_features(features, flight_, *heights_, strips, truth_, options_.images, *score_.value);
    } catch (const std::exception& fault) {
      score_.remarks.emplace_back(fault.what());
    }
  }

  const intake::Flight& flight_;
  const DenseOptions& options_;
  TrueFrames truth_;
  std::optional<world::HeightGrid> heights_;
  map::PixelRays rays_;
  DenseScore score_;
  DepthErrors all_;
  std::vector<float> all_heights_, metric_heights_;
  std::vector<double> flying_heights_;
};

std::optional<CameraModel> camera_of(const intake::Flight& flight, const DenseOptions& options) {
  if (options.camera) return options.camera;
  if (const auto truth = true_camera(options.truth)) return truth;
  // The flight's own camera is the next best.
  if (flight.camera) return flight.camera;
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (keyframe.camera.width > 0) return keyframe.camera;
  }
  return std::nullopt;
}

}  // namespace

DenseScore score_dense(const intake::Flight& flight, const report::Reference& reference, const DenseOptions& options) {
  const auto camera = camera_of(flight, options);
  if (camera) return DenseScorer(flight, reference, *camera, options).run();
  DenseScore score;
  score.remarks.emplace_back("no camera came down: depths, masks and overlaps cannot be compared");
  return score;
}

}  // namespace ilp::score
