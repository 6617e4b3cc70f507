#include "sim/tools/score/score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "cfg/mission.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/ground/intake/flight_info.hpp"
#include "sim/host/files.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/text_format.hpp"
#include "sim/tools/score/calibration_score.hpp"
#include "sim/tools/score/fix_score.hpp"
#include "sim/tools/score/score_json.hpp"
#include "sim/tools/score/tie_score.hpp"

namespace ilp::score {
namespace fs = std::filesystem;
namespace {

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

report::ReferenceFiles open_truth(const ScoreOptions& options) {
  if (!options.reference.empty()) return {options.reference, fs::path()};
  const fs::path truth = truth_folder(options);
  if (!is_there(truth / "poses.txt")) {
    throw std::runtime_error("no truth to score against: " + (truth / "poses.txt").string() +
                             " is not there (--truth FOLDER or --reference poses.txt name another)");
  }
  return {truth / "poses.txt", truth / "depth"};
}

void read_info(const ScoreOptions& options, FlightFiles& files) {
  const fs::path path = options.flight / "flight-info.json";
  if (!is_there(path)) {
    files.remarks.push_back("there is no flight-info.json: the flight did not end by itself");
    return;
  }
  try {
    files.info = intake::read_flight_info(path);
  } catch (const std::exception& error) {
    files.remarks.push_back(std::string("flight information cannot be used: ") + error.what());
  }
}

std::vector<intake::RecordEntry> onboard_records(const ScoreOptions& options, FlightFiles& files) {
  const fs::path path = options.flight / "flight.db";
  if (is_there(path)) return intake::read_flight_database(path);
  files.remarks.push_back("there is no flight.db: only what came down is scored");
  return {};
}

void read_down(const ScoreOptions& options, FlightFiles& files) {
  const bool named = !options.received.empty();
  const fs::path folder = named ? options.received : options.flight / "outbox";
  if (!is_there(folder)) {
    if (named) throw std::runtime_error("--received " + folder.string() + ": there is no such folder");
    files.remarks.push_back("there is no outbox: nothing came down");
    return;
  }
  files.outbox = intake::read_outbox(folder);
}

/// Products were made, and no file is there: over a link they went to a station.
void remark_other_folder(const ScoreOptions& options, FlightFiles& files) {
  if (!files.outbox.files.empty() || !options.received.empty()) return;
  const bool any = std::any_of(files.flight.keyframes.begin(), files.flight.keyframes.end(), [](const auto& entry) {
    const auto& products = entry.second.product_records;
    return products[0].has_value() || products[1].has_value();
  });
  if (any) {
    files.remarks.push_back((options.flight / "outbox").string() +
                            " holds no file although products were made; after a flight over a link, name the "
                            "station's folder with --received");
  }
}

// After the products were decoded: that finds damage too.
void remark_damage(FlightFiles& files) {
  std::size_t damaged = 0;
  std::string first;
  for (const intake::ReceivedFile& file : files.outbox.files) {
    if (file.fault.empty()) continue;
    if (damaged++ == 0) first = file.name + ", " + file.fault;
  }
  if (damaged > 0) {
    files.remarks.push_back(host::counted(damaged, "file") + " of the outbox cannot be used; the first: " + first);
  }
}

void remark_open_strips(FlightFiles& files) {
  for (const auto& [id, strip] : files.flight.strips) {
    if (!strip.record || strip.record->end != StripEnd::open) continue;
    files.remarks.push_back("strip " + std::to_string(id) + " was still open: its last poses are not final");
  }
}

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
  sample.ground_distance = keyframe.pose->ground_distance;
  if (keyframe.navigation && keyframe.navigation->height_sigma_m > 0) {
    sample.measured_height_m = keyframe.navigation->height_m;
  }
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

/// A pair of these begins the structure.
constexpr std::size_t first_of_a_strip = 5;

StripScore score_strip(const FlightFiles& files, const intake::Strip& strip) {
  StripScore score;
  score.id = strip.id;
  score.keyframes = strip.keyframes.size();
  score.first_keyframes = score.keyframes < 2 ? 0 : std::min(score.keyframes, first_of_a_strip);
  StripTrack first;
  std::size_t place = 0;
  for (const std::int64_t id : strip.keyframes) {
    const bool among_first = place++ < score.first_keyframes;
    const intake::Keyframe& keyframe = files.flight.keyframes.at(id);
    if (!keyframe.posed()) continue;
    ++score.posed;
    score.first_posed += among_first ? 1U : 0U;
    score.track.metric = keyframe.pose->scale_source != ScaleSource::first_baseline;
    const report::ReferencePose* truth = files.reference->pose(keyframe.name);
    if (truth == nullptr && score.posed <= 2) score.track.from_the_start = false;
    if (truth != nullptr) score.track.samples.push_back(sample_of(keyframe, *truth));
    if (truth != nullptr && among_first) first.samples.push_back(score.track.samples.back());
  }
  if (score.track.samples.empty()) return score;
  score.length = distance_flown(score.track).back();
  score.track.flying_height = flying_height(files, score.track);
  score.poses = score_poses(score.track);
  score.first_poses = score_poses(first);
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
    if (!strip.poses || !(strip.length > 0)) continue;
    const double rotation_deg = degrees * host::summarise(strip.poses->rotation_rad).mean;
    const double position_percent = 100 * strip.poses->position.mean / strip.length;
    const std::string foreign = report::foreign_reference(known, rotation_deg, position_percent);
    if (!foreign.empty()) score.remarks.push_back(strip_name(strip) + ": " + foreign);
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

void add_first(const Score& score, std::map<std::string, double>& summary) {
  LengthMean mean;
  std::size_t keyframes = 0, posed = 0;
  for (const StripScore& strip : score.strips) {
    keyframes += strip.first_keyframes;
    posed += strip.first_posed;
    if (!strip.first_poses) continue;
    const double length = strip.first_poses->length();
    mean.add(100 * strip.first_poses->position.mean / length, length);
  }
  summary["first_five_posed_share"] =
      keyframes > 0 ? static_cast<double>(posed) / static_cast<double>(keyframes) : nothing;
  summary["first_five_mean_percent"] = mean.value();
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

DenseScore dense_score(const ScoreOptions& options, const FlightFiles& files) {
  DenseOptions dense;
  dense.target_overlap = files.target_overlap;
  if (options.reference.empty()) dense.truth = truth_folder(options);
  std::error_code error;
  if (fs::is_directory(options.flight / "flight" / "images", error))
    dense.images = options.flight / "flight" / "images";
  // Images that were rendered for many flights lie beside their truth.
  const fs::path beside = truth_folder(options).parent_path() / "images";
  if (dense.images.empty() && options.reference.empty() && fs::is_directory(beside, error)) dense.images = beside;
  return score_dense(files.flight, *files.reference, dense);
}

// All strips lie on the grid of the true heights; where two overlap, the first stands.
void write_height_errors(const DenseScore& dense, const fs::path& path) {
  host::Raster<float> map;
  for (const auto& [id, strip] : dense.strips) {
    if (!strip.height || strip.height->error_map.empty()) continue;
    const host::Raster<float>& errors = strip.height->error_map;
    if (map.samples.empty()) map = host::Raster<float>(errors.width, errors.height, std::nanf(""));
    for (std::size_t i = 0; i < map.samples.size(); ++i) {
      if (std::isnan(map.samples[i])) map.samples[i] = errors.samples[i];
    }
  }
  std::error_code ignored;
  fs::remove(path, ignored);
  if (!map.samples.empty()) host::write_pfm(path, map.view());
}

/// Angle between the strip's up and the true one, rad: mean over the attitudes.
double tilt_of(const StripTrack& track) {
  Vec3 up = Vec3::Zero();
  for (const PoseSample& s : track.samples) up += s.true_cam_from_world.transpose() * s.cam_from_world.col(2);
  return std::acos(std::clamp(up.normalized().z(), -1.0, 1.0));
}

}  // namespace

fs::path truth_folder(const ScoreOptions& options) {
  return options.truth.empty() ? options.flight / "flight" / "truth" : options.truth;
}

FlightFiles open_flight(const ScoreOptions& options) {
  if (!is_there(options.flight / "flight.db") && !is_there(options.flight / "outbox")) {
    throw std::runtime_error(options.flight.string() +
                             " holds no flight: expected flight.db and outbox/, as ilp-sil --out leaves them");
  }
  FlightFiles files;
  files.reference = open_truth(options);
  read_info(options, files);
  std::vector<intake::RecordEntry> onboard = onboard_records(options, files);
  read_down(options, files);
  // What came down is read last, so that it stands over what the database says.
  onboard.insert(onboard.end(), std::make_move_iterator(files.outbox.records.begin()),
                 std::make_move_iterator(files.outbox.records.end()));
  files.outbox.records = std::move(onboard);
  files.flight = intake::build_flight(files.outbox);
  remark_other_folder(options, files);
  remark_damage(files);
  remark_open_strips(files);
  files.complete = files.remarks.empty();
  files.remarks.insert(files.remarks.end(), files.flight.remarks.begin(), files.flight.remarks.end());
  files.target_overlap = (files.info ? files.info->target_overlap : std::nullopt).value_or(unknown);
  return files;
}

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
  summary["strips"] = static_cast<double>(score.strips.size());
  summary["frames_per_keyframe"] = keyframes > 0 && frames > 0 ? frames / keyframes : nothing;
  summary["posed_share"] = keyframes > 0 ? static_cast<double>(score.posed) / keyframes : nothing;
  add_positions(score, summary);
  add_first(score, summary);
  add_growth(score, summary);
  return summary;
}

std::map<std::string, double> navigation_summary(const Score& score, const intake::Flight& flight) {
  std::map<std::string, double> summary;
  LengthMean scale, scale_sigmas, tilt, tilt_sigmas, bow;
  for (const StripScore& strip : score.strips) {
    const auto& frame = flight.strips.at(strip.id).frame;
    if (!frame || !strip.poses) continue;
    const auto bow_after_heights = bow_after_heights_percent(strip.track);
    if (bow_after_heights) bow.add(std::fabs(*bow_after_heights), strip.length);
    const double scale_error = std::fabs(strip.poses->true_from_strip.scale - 1), tilt_error = tilt_of(strip.track);
    if (frame->scale_sigma > 0) {
      scale.add(100 * scale_error, strip.length);
      scale_sigmas.add(scale_error / frame->scale_sigma, strip.length);
    }
    if (frame->tilt_sigma_rad > 0) {
      tilt.add(degrees * tilt_error, strip.length);
      tilt_sigmas.add(tilt_error / frame->tilt_sigma_rad, strip.length);
    }
  }
  for (const auto& [key, mean] :
       {std::pair("scale_error_percent", scale), std::pair("scale_error_sigmas", scale_sigmas),
        std::pair("tilt_error_deg", tilt), std::pair("tilt_error_sigmas", tilt_sigmas),
        std::pair("bow_after_heights_percent", bow)}) {
    if (std::isfinite(mean.value())) summary[key] = mean.value();
  }
  return summary;
}

void run_score(const ScoreOptions& options, const fs::path& out, std::ostream& table) {
  const FlightFiles files = open_flight(options);
  Score score = score_poses_of(files);
  const DenseScore dense = dense_score(options, files);
  score.remarks.insert(score.remarks.end(), dense.remarks.begin(), dense.remarks.end());
  std::map<std::string, double> summary = summary_of(score);
  summary.merge(dense_summary(dense));
  summary.merge(navigation_summary(score, files.flight));
  const std::optional<CameraModel> camera =
      options.reference.empty() ? true_camera(truth_folder(options)) : std::nullopt;
  if (files.reference) summary.merge(fix_summary(score_fixes(files.flight, *files.reference, camera)));
  summary.merge(tie_summary(score_ties(files.flight, score.strips)));
  double bytes = 0;
  for (const intake::ReceivedFile& file : files.outbox.files) bytes += static_cast<double>(file.bytes);
  summary["received_mb"] = 1e-6 * bytes;
  summary.merge(calibration_summary(files.flight, camera));
  nlohmann::ordered_json json = score_json(score, files);
  json["summary"] = summary_json(summary);
  json["dense"] = dense_json(dense);
  const fs::path path = out.empty() ? options.flight / "score.json" : out;
  // Names from damaged files need not be UTF-8.
  host::write_file(path, json.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
  write_height_errors(dense, path.parent_path() / "height-error.pfm");
  write_table(score, summary, table);
  table << "score: " << path.string() << "\n";
}

}  // namespace ilp::score
