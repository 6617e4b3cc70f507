#include "sim/tools/score/score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::score {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

PoseSample sample_of(const intake::Keyframe& keyframe, const report::ReferencePose& truth) {
  const Pose pose = pose_of(*keyframe.pose);
  const double(&sigma)[3] = keyframe.pose->sigma;
  PoseSample sample;
  sample.keyframe_id = keyframe.id;
  sample.cam_from_world = rotation_from_quaternion(pose.q_cam_from_world);
  sample.centre = Vec3(pose.centre[0], pose.centre[1], pose.centre[2]);
  sample.sigma = Vec3(sigma[0], sigma[1], sigma[2]);
  if (!sample.sigma.allFinite()) sample.sigma.setZero();
  sample.true_cam_from_world = truth.cam_from_world;
  sample.true_centre = truth.centre;
  return sample;
}

double median_depth(const host::Raster<float>& depth) {
  std::vector<double> values;
  for (const float z : depth.samples) {
    if (z > 0 && std::isfinite(z)) values.push_back(z);
  }
  return host::median(std::move(values));
}

// From the true depths; where there are none, from the depths that the flight states, in the truth's unit.
double flying_height(const FlightFiles& files, const StripTrack& track) {
  std::vector<double> heights, stated;
  for (const PoseSample& s : track.samples) {
    const intake::Keyframe& keyframe = files.flight.keyframes.at(s.keyframe_id);
    const double height = median_depth(files.reference->depth(keyframe.name));
    if (height > 0) heights.push_back(height);
    if (keyframe.pose->max_depth > 0) stated.push_back(0.5 * (keyframe.pose->min_depth + keyframe.pose->max_depth));
  }
  if (!heights.empty()) return host::median(std::move(heights));
  const std::size_t count = track.samples.size();
  const auto alignment =
      stated.empty() ? std::nullopt : host::align_positions(track.estimate(count).centres, track.truth(count).centres);
  return alignment ? alignment->scale * host::median(std::move(stated)) : 0;
}

StripScore score_strip(const FlightFiles& files, const intake::Strip& strip) {
  StripScore score;
  score.id = strip.id;
  score.keyframes = strip.keyframes.size();
  for (const std::int64_t id : strip.keyframes) {
    const intake::Keyframe& keyframe = files.flight.keyframes.at(id);
    if (!keyframe.posed()) continue;
    ++score.posed;
    score.track.metric = keyframe.pose->scale_source == ScaleSource::altimeter;
    const report::ReferencePose* truth = files.reference->pose(keyframe.name);
    if (truth == nullptr && score.posed <= 2) score.track.from_the_start = false;
    if (truth != nullptr) score.track.samples.push_back(sample_of(keyframe, *truth));
  }
  if (score.track.samples.empty()) return score;
  score.length = distance_flown(score.track).back();
  score.track.flying_height = flying_height(files, score.track);
  score.poses = score_poses(score.track);
  score.drift = measure_drift(score.track);
  score.scale_drift = measure_scale_drift(score.track);
  score.bow = measure_bow(score.track);
  score.sigmas = score_sigmas(score.track);
  return score;
}

std::string strip_name(const StripScore& strip) {
  return "strip " + std::to_string(strip.id);
}

void remark_strips(Score& score) {
  if (score.posed == 0) score.remarks.emplace_back("no keyframe has a final pose");
  for (const StripScore& strip : score.strips) {
    const std::size_t known = strip.track.samples.size();
    if (known < strip.posed) {
      score.remarks.push_back(strip_name(strip) + ": the truth knows " + std::to_string(known) + " of its " +
                              std::to_string(strip.posed) + " posed keyframes");
    }
    if (known > 0 && !strip.poses) {
      score.remarks.push_back(strip_name(strip) + ": " + std::to_string(known) +
                              " poses are too few, or too close together, to align and still measure an error (" +
                              std::to_string(fewest_poses) + " are needed)");
    }
  }
}

class LengthMean {
 public:
  void add(double value, double length) {
    if (!std::isfinite(value) || !(length > 0)) return;
    sum_ += value * length;
    length_ += length;
  }
  [[nodiscard]] double value() const { return length_ > 0 ? sum_ / length_ : nothing; }

 private:
  double sum_ = 0, length_ = 0;
};

void add_positions(const Score& score, std::map<std::string, double>& summary) {
  LengthMean mean, max, rigid;
  std::vector<double> rotations;
  for (const StripScore& strip : score.strips) {
    if (!strip.poses || !(strip.length > 0)) continue;
    const PoseScore& poses = *strip.poses;
    mean.add(100 * poses.position.mean / strip.length, strip.length);
    max.add(100 * poses.position.max / strip.length, strip.length);
    if (poses.position_rigid) rigid.add(100 * poses.position_rigid->mean / strip.length, strip.length);
    for (const double angle : poses.rotation_rad) rotations.push_back(degrees * angle);
  }
  const host::ErrorSummary rotation = host::summarise(rotations);
  summary["position_mean_percent"] = mean.value();
  summary["position_max_percent"] = max.value();
  summary["position_rigid_mean_percent"] = rigid.value();
  summary["rotation_mean_deg"] = rotations.empty() ? nothing : rotation.mean;
  summary["rotation_max_deg"] = rotations.empty() ? nothing : rotation.max;
}

void add_growth(const Score& score, std::map<std::string, double>& summary) {
  LengthMean drift, scale, bow;
  SigmaScore sigmas;
  for (const StripScore& strip : score.strips) {
    if (strip.drift) drift.add(strip.drift->percent, strip.length);
    if (strip.scale_drift) scale.add(std::fabs(strip.scale_drift->percent), strip.length);
    if (strip.bow) bow.add(std::fabs(strip.bow->percent), strip.length);
    sigmas.add(strip.sigmas);
  }
  summary["drift_percent"] = drift.value();
  summary["scale_drift_percent"] = scale.value();
  summary["bow_percent"] = bow.value();
  summary["sigma1_share"] = sigmas.share_within_one();
  summary["sigma2_share"] = sigmas.share_within_two();
  summary["position_nes"] = sigmas.normalised_error_squared();
}

}  // namespace

Score score_poses_of(const FlightFiles& files) {
  Score score;
  score.complete = files.complete;
  score.remarks = files.remarks;
  score.target_overlap = files.target_overlap;
  score.keyframes = files.flight.keyframes.size();
  score.frames = files.flight.frames.size();
  if (score.frames == 0 && files.info) score.frames = static_cast<std::size_t>(files.info->frames.value_or(0));
  std::size_t known = 0;
  for (const auto& [id, strip] : files.flight.strips) {
    if (strip.keyframes.empty()) continue;
    score.strips.push_back(score_strip(files, strip));
    score.posed += score.strips.back().posed;
    known += score.strips.back().track.samples.size();
  }
  if (score.posed > 0 && known == 0) {
    throw std::runtime_error("the truth knows none of the " + std::to_string(score.posed) +
                             " posed images by name: it is another flight's");
  }
  remark_strips(score);
  return score;
}

std::map<std::string, double> summary_of(const Score& score) {
  const auto frames = static_cast<double>(score.frames), keyframes = static_cast<double>(score.keyframes);
  std::map<std::string, double> summary;
  summary["frames"] = frames;
  summary["keyframes"] = keyframes;
  summary["frames_per_keyframe"] = keyframes > 0 && frames > 0 ? frames / keyframes : nothing;
  summary["posed_share"] = keyframes > 0 ? static_cast<double>(score.posed) / keyframes : nothing;
  add_positions(score, summary);
  add_growth(score, summary);
  return summary;
}

}  // namespace ilp::score
