// Both dense matchers, beside OpenCV's semi-global matching where OpenCV is installed, on pairs whose disparities are
// known: simulated flights with their truth, and the Middlebury pairs. Prints a table; docs/dense-matching.md has one.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/stereo/match/stereo_matcher.hpp"
#include "fsw/vision/stereo/rectify/rectification.hpp"
#include "fsw/vision/stereo/rectify/resample.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/statistics.hpp"
#include "sim/tools/lab/colmap_reader.hpp"
#include "tests/unit/vision/stereo/middlebury.hpp"

#ifdef ILP_HAVE_OPENCV_CALIB3D
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#endif

namespace ilp::peers {
namespace fs = std::filesystem;
namespace {

using Gray = host::Raster<std::uint8_t>;
using Map = host::Raster<float>;

struct Pair {
  std::string name;
  Gray left, right, left_valid, right_valid;
  DisparityRange range;
  Map truth;          ///< px; not a number where it is not known or the other image does not see the point
  double bound_px{};  ///< errors above it are wrong
  bool terrain = true;
  // The members below belong to pairs of a simulated flight.
  Map height;      ///< of the ground, m; not a number where it is not known
  int second = 0;  ///< number of the right image's frame
  RectifiedPair rectified;
  RigidTransform left_from_world;
};

/// What a matcher said; invalid pixels are not numbers.
struct Answer {
  std::string matcher;
  Map disparity;
  Map sigma;  ///< empty: unknown
  double seconds = 0;
};

float none() {
  return std::nanf("");
}

// --- pairs of a simulated flight

struct Frame {
  Gray image;
  Map depth;
  RigidTransform cam_from_world;
};

float bilinear(const Map& map, const Vec2& at) {
  const double x0 = std::floor(at.x()), y0 = std::floor(at.y());
  const int x = static_cast<int>(x0), y = static_cast<int>(y0);
  if (x < 0 || y < 0 || x + 1 >= map.width || y + 1 >= map.height) return none();
  const auto fx = static_cast<float>(at.x() - x0), fy = static_cast<float>(at.y() - y0);
  const float top = map.at(x, y) * (1 - fx) + map.at(x + 1, y) * fx;
  const float bottom = map.at(x, y + 1) * (1 - fx) + map.at(x + 1, y + 1) * fx;
  return top * (1 - fy) + bottom * fy;
}

/// Disparity of the rectified left pixel, by the truth's depth on the real pixels; not a number where the right image
/// does not see the point: out of its frame, or something stands before it.
float true_disparity(const RectifiedPair& pair, const CameraModel& camera, const Frame& left, const Frame& right,
                     double x, double y, float& height) {
  height = none();
  const Vec3 ray =
      pair.rect_from_left.transpose() * Vec3((x - pair.cx_left) / pair.focal_px, (y - pair.cy) / pair.focal_px, 1);
  if (!(ray.z() > 0)) return none();
  const float depth = bilinear(left.depth, pixel_from_normalised(camera, Vec2(ray.x(), ray.y()) / ray.z()));
  if (!(depth > 0)) return none();
  const Vec3 in_left = ray / ray.z() * static_cast<double>(depth);
  const Vec3 world = left.cam_from_world.rotation.transpose() * (in_left - left.cam_from_world.translation);
  height = static_cast<float>(world.z());
  const Vec3 in_right = right.cam_from_world * world;
  if (!(in_right.z() > 0)) return none();
  const Vec2 normalised(in_right.x() / in_right.z(), in_right.y() / in_right.z());
  const float seen = bilinear(right.depth, pixel_from_normalised(camera, normalised));
  const double z = (pair.rect_from_left * in_left).z();
  const double disparity = pair.focal_px * pair.baseline / z;
  // Hidden by something nearer by a pixel of disparity or more.
  if (!(static_cast<double>(seen) > in_right.z() * (1 - 1 / std::max(disparity, 2.0)))) return none();
  return static_cast<float>(x - rectified_right(pair, normalised).x());
}

std::string stem(int number) {
  char text[16];
  std::snprintf(text, sizeof(text), "%04d", number);
  return text;
}

Frame read_frame(const fs::path& flight, const lab::ColmapModel& model, int number) {
  const std::string name = stem(number);
  return {host::read_gray(flight / "images" / (name + ".pgm")),
          host::read_pfm(flight / "truth/depth" / (name + ".pfm")),
          lab::find_image(model, name + ".pgm").cam_from_world};
}

/// The first later frame that shows at most `share` of this one's ground; 0 when there is none.
int partner(const fs::path& flight, int number, double share) {
  std::ifstream file(flight / "truth/overlap.csv");
  int best = 0;
  for (std::string line; std::getline(file, line);) {
    int a = 0, b = 0;
    double overlap = 0;
    if (std::sscanf(line.c_str(), "%d,%d,%lf", &a, &b, &overlap) != 3) continue;
    if (a == number && b > a && overlap <= share && (best == 0 || b < best)) best = b;
  }
  return best;
}

bool flight_pair(const fs::path& flight, int number, double share, Pair& out) {
  const int second = partner(flight, number, share);
  if (second == 0) return false;
  const lab::ColmapModel model = lab::read_colmap_model(flight / "truth/colmap");
  const Frame left = read_frame(flight, model, number), right = read_frame(flight, model, second);
  std::vector<float> depths(left.depth.samples);
  std::erase_if(depths, [](float d) { return !(d > 0) || !std::isfinite(d); });
  std::sort(depths.begin(), depths.end());
  // As onboard, where the range comes from sparse points.
  const std::size_t cut = depths.size() / 50;
  DepthRange depth{static_cast<double>(depths[cut]), static_cast<double>(depths[depths.size() - 1 - cut])};
  depth = {depth.nearest * 0.9, depth.farthest * 1.1};
  RectifiedPair pair;
  const Status planned =
      plan_rectification(model.camera, left.cam_from_world, right.cam_from_world, depth, {}, pair, out.range);
  if (!planned.ok()) return false;
  out.name = flight.parent_path().filename().string() + " " + stem(number) + "-" + stem(second);
  out.bound_px = 1;
  out.second = second;
  out.rectified = pair;
  out.left_from_world = left.cam_from_world;
  for (Gray* image : {&out.left, &out.right, &out.left_valid, &out.right_valid}) *image = Gray(pair.width, pair.height);
  const bool resampled = resample_rows(pair, Side::left, model.camera, left.image.view(), 0, pair.height,
                                       out.left.view(), out.left_valid.view())
                             .ok() &&
                         resample_rows(pair, Side::right, model.camera, right.image.view(), 0, pair.height,
                                       out.right.view(), out.right_valid.view())
                             .ok();
  if (!resampled) return false;
  out.truth = out.height = Map(pair.width, pair.height, none());
  for (int y = 0; y < pair.height; ++y) {
    for (int x = 0; x < pair.width; ++x) {
      if (out.left_valid.at(x, y) == 0) continue;
      const float d = true_disparity(pair, model.camera, left, right, x, y, out.height.at(x, y));
      const double target = x - static_cast<double>(d);
      if (!(target >= 0 && target <= pair.width - 1)) continue;
      if (out.right_valid.at(static_cast<int>(std::lround(target)), y) != 0) out.truth.at(x, y) = d;
    }
  }
  return true;
}

// --- Middlebury

Gray copy_of(const test::Image& image) {
  Gray out(image.width, image.height);
  out.samples = image.pixels;
  return out;
}

bool middlebury_pair(const char* name, std::int32_t disparities, Pair& out) {
  const test::StereoPair pair = test::read_stereo_pair(name);
  if (pair.left.empty()) return false;
  out.name = name;
  out.left = copy_of(pair.left);
  out.right = copy_of(pair.right);
  out.left_valid = out.right_valid = Gray(out.left.width, out.left.height, 255);
  out.range = {0, disparities - 1};
  out.bound_px = 2;
  out.terrain = false;
  out.truth = Map(out.left.width, out.left.height, none());
  for (std::size_t i = 0; i < pair.truth_px.size(); ++i) {
    if (pair.evaluated[i] != 0) out.truth.samples[i] = static_cast<float>(pair.truth_px[i]);
  }
  return true;
}

// --- matchers

Answer ours(const Pair& pair, const StereoParams& params) {
  static const auto workspace = std::make_unique<StereoWorkspace>();
  const int width = pair.left.width, height = pair.left.height;
  Answer answer{name_of(params.matcher), Map(width, height), Map(width, height), 0};
  const auto begin = std::chrono::steady_clock::now();
  StereoMatcher matcher;
  Status status = matcher.begin(pair.left.view(), pair.right.view(), pair.left_valid.view(), pair.right_valid.view(),
                                pair.range, params, *workspace, {answer.disparity.view(), answer.sigma.view()});
  if (status.ok()) status = do_all([&] { return matcher.step(64); });
  answer.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (!status.ok()) throw std::runtime_error(pair.name + ": " + status_name(status.code));
  for (std::size_t i = 0; i < answer.disparity.samples.size(); ++i) {
    if (answer.sigma.samples[i] == 0) answer.disparity.samples[i] = none();
  }
  return answer;
}

Answer ours(const Pair& pair, StereoMatcherChoice choice) {
  StereoParams params = pair.terrain ? StereoParams{} : test::still_life_params();
  params.matcher = choice;
  return ours(pair, params);
}

#ifdef ILP_HAVE_OPENCV_CALIB3D
struct SgbmSetting {
  const char* name;
  int mode, block, uniqueness;
  /// A border on the left of both images, as wide as the search: bare images lose that many columns.
  bool border;
};

Answer sgbm(const Pair& pair, const SgbmSetting& setting) {
  const int width = pair.left.width, height = pair.left.height;
  const int count = (pair.range.count() + 15) / 16 * 16;
  const int border = setting.border ? std::max(0, pair.range.min_px + count) : 0;
  const auto padded = [&](const Gray& image) {
    const cv::Mat whole(height, width, CV_8U, const_cast<std::uint8_t*>(image.samples.data()));
    cv::Mat out;
    cv::copyMakeBorder(whole, out, 0, 0, border, 0, cv::BORDER_REPLICATE);
    return out;
  };
  const cv::Mat left = padded(pair.left), right = padded(pair.right);
  const int area = setting.block * setting.block;
  const auto matcher = cv::StereoSGBM::create(pair.range.min_px, count, setting.block, 8 * area, 32 * area, 1, 63,
                                              setting.uniqueness, 100, 2, setting.mode);
  cv::Mat found;
  const auto begin = std::chrono::steady_clock::now();
  matcher->compute(left, right, found);
  Answer answer{setting.name, Map(width, height, none()), {}, 0};
  answer.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto d = static_cast<float>(found.at<short>(y, x + border)) / 16.0F;
      if (d >= static_cast<float>(pair.range.min_px) && pair.left_valid.at(x, y) != 0) answer.disparity.at(x, y) = d;
    }
  }
  return answer;
}

constexpr SgbmSetting settings[] = {
    {"SGBM 3x3", cv::StereoSGBM::MODE_SGBM, 3, 10, true},
    {"SGBM 5x5", cv::StereoSGBM::MODE_SGBM, 5, 10, true},
    {"SGBM 7x7", cv::StereoSGBM::MODE_SGBM, 7, 10, true},
    {"SGBM 5x5 u0", cv::StereoSGBM::MODE_SGBM, 5, 0, true},
    {"SGBM 5x5 bare", cv::StereoSGBM::MODE_SGBM, 5, 10, false},
    {"3WAY 5x5", cv::StereoSGBM::MODE_SGBM_3WAY, 5, 10, true},
    {"HH 5x5", cv::StereoSGBM::MODE_HH, 5, 10, true},
};
#endif

std::vector<Answer> answers_of_all(const Pair& pair) {
  std::vector<Answer> answers;
  for (const EnumValue& value : StereoMatcherChoice_values) {
    answers.push_back(ours(pair, static_cast<StereoMatcherChoice>(value.number)));
  }
#ifdef ILP_HAVE_OPENCV_CALIB3D
  cv::setNumThreads(1);
  for (const SgbmSetting& setting : settings) answers.push_back(sgbm(pair, setting));
#endif
  return answers;
}

// --- scores

/// Where there is something to match: grey varies by 2 levels or more (one sigma) within 5 x 5 pixels. The noise of a
/// blank surface varies by half of that.
Gray textured_places(const Gray& image) {
  constexpr int radius = 2;
  constexpr double least_deviation = 2;
  Gray out(image.width, image.height, 0);
  for (int y = radius; y + radius < image.height; ++y) {
    for (int x = radius; x + radius < image.width; ++x) {
      double sum = 0, squares = 0;
      for (int v = y - radius; v <= y + radius; ++v) {
        for (int u = x - radius; u <= x + radius; ++u) {
          const double grey = image.at(u, v);
          sum += grey;
          squares += grey * grey;
        }
      }
      constexpr double n = (2 * radius + 1) * (2 * radius + 1);
      if (squares / n - sum * sum / (n * n) >= least_deviation * least_deviation) out.at(x, y) = 1;
    }
  }
  return out;
}

/// Pixel locking: how the mean error depends on where between two whole pixels the truth is. Half of the span of the
/// means over tenths of a pixel.
class Locking {
 public:
  void take(double truth, double error) {
    const auto bin = static_cast<std::size_t>(bins * (truth - std::floor(truth)));
    sum_[std::min(bin, bins - 1)] += error;
    ++count_[std::min(bin, bins - 1)];
  }
  [[nodiscard]] double amplitude_px() const {
    double least = 1e9, most = -1e9;
    for (std::size_t i = 0; i < bins; ++i) {
      if (count_[i] < 100) continue;
      least = std::min(least, sum_[i] / static_cast<double>(count_[i]));
      most = std::max(most, sum_[i] / static_cast<double>(count_[i]));
    }
    return most < least ? 0 : (most - least) / 2;
  }

 private:
  static constexpr std::size_t bins = 10;
  std::array<double, bins> sum_{};
  std::array<std::size_t, bins> count_{};
};

struct Score {
  double wrong = 0;     ///< share of the pixels that both images see
  double complete = 0;  ///< share with an answer
  double median_px = 0, locking_px = 0;
  double one_sigma = 0, two_sigma = 0;  ///< share of the errors inside
};

/// Over the places where `where` is not 0; everywhere when it is empty.
Score score(const Pair& pair, const Answer& answer, const Gray& where) {
  std::vector<double> errors;
  Locking locking;
  std::size_t known = 0, inside_one = 0, inside_two = 0, wrong = 0;
  for (std::size_t i = 0; i < pair.truth.samples.size(); ++i) {
    if (!std::isfinite(pair.truth.samples[i]) || (!where.samples.empty() && where.samples[i] == 0)) continue;
    ++known;
    if (!std::isfinite(answer.disparity.samples[i])) continue;
    const auto difference = static_cast<double>(answer.disparity.samples[i] - pair.truth.samples[i]);
    const double error = std::fabs(difference);
    errors.push_back(error);
    if (error <= pair.bound_px) locking.take(static_cast<double>(pair.truth.samples[i]), difference);
    wrong += error > pair.bound_px ? 1 : 0;
    if (answer.sigma.samples.empty()) continue;
    const auto sigma = static_cast<double>(answer.sigma.samples[i]);
    inside_one += error <= sigma ? 1 : 0;
    inside_two += error <= 2 * sigma ? 1 : 0;
  }
  if (errors.empty()) return {};
  const auto n = static_cast<double>(errors.size()), all = static_cast<double>(known);
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  return {static_cast<double>(wrong) / all,    n / all,
          errors[errors.size() / 2],           locking.amplitude_px(),
          static_cast<double>(inside_one) / n, static_cast<double>(inside_two) / n};
}

// --- what one rule brings, with the flight's own parameters

/// The level that most of the ground has, if it is liquid: all on one height.
float liquid_level(const Map& height) {
  constexpr float step = 0.02F;
  std::map<long, std::size_t> counts;
  std::size_t known = 0;
  for (const float z : height.samples) {
    if (!std::isfinite(z)) continue;
    ++counts[std::lround(z / step)];
    ++known;
  }
  const auto most =
      std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most != counts.end() && 50 * most->second > known ? step * static_cast<float>(most->first) : none();
}

class RuleScore {
 public:
  RuleScore(const char* name, void (*turn_off)(StereoParams&)) : name_(name), turn_off_(turn_off) {}

  void compare(const Pair& pair) {
    StereoParams params;
    const Answer with = ours(pair, params);
    turn_off_(params);
    const Answer without = ours(pair, params);
    ratios_.push_back(with.seconds / without.seconds);
    const float level = liquid_level(pair.height);
    for (std::size_t i = 0; i < pair.truth.samples.size(); ++i) {
      const bool added = is_new(with.disparity.samples[i], without.disparity.samples[i]);
      added_ += added ? 1 : 0;
      // Narrower than any slope of a shore makes of a pixel.
      const bool gained = added && !std::isfinite(without.disparity.samples[i]);
      if (gained && !pair.height.samples.empty() && std::fabs(pair.height.samples[i] - level) < 0.004F) ++on_liquid_;
      const auto truth = static_cast<double>(pair.truth.samples[i]);
      if (!std::isfinite(truth)) continue;
      ++known_;
      take(without, i, truth, pair.bound_px, valid_without_, wrong_without_);
      take(with, i, truth, pair.bound_px, valid_, wrong_);
      if (!added) continue;
      const double error = std::fabs(static_cast<double>(with.disparity.samples[i]) - truth);
      const auto sigma = static_cast<double>(with.sigma.samples[i]);
      ++measured_;
      right_ += error <= pair.bound_px ? 1 : 0;
      in_one_ += error <= sigma ? 1 : 0;
      in_two_ += error <= 2 * sigma ? 1 : 0;
    }
  }
  void print() const {
    std::printf(
        "%s, flight's parameters: bad %.2f %%, without %.2f %%; wrong among the valid %.2f %%, without %.2f %%\n"
        "  %zu new or changed; %zu new ones on liquid; %.1f %% right; in 1, 2 sigma: %.2f, %.2f; median time %.2f of "
        "without\n",
        name_, percent(known_ - valid_ + wrong_, known_), percent(known_ - valid_without_ + wrong_without_, known_),
        percent(wrong_, valid_), percent(wrong_without_, valid_without_), added_, on_liquid_,
        percent(right_, measured_), percent(in_one_, measured_) / 100, percent(in_two_, measured_) / 100,
        host::median(ratios_));
  }

 private:
  static double percent(std::size_t part, std::size_t whole) {
    return whole > 0 ? 100 * static_cast<double>(part) / static_cast<double>(whole) : 0;
  }
  static void take(const Answer& answer, std::size_t i, double truth, double bound_px, std::size_t& valid,
                   std::size_t& wrong) {
    const auto d = static_cast<double>(answer.disparity.samples[i]);
    if (!std::isfinite(d)) return;
    ++valid;
    wrong += std::fabs(d - truth) > bound_px ? 1 : 0;
  }

  /// Without the rule there is no disparity, or one of another surface.
  static bool is_new(float with, float without) {
    return std::isfinite(with) && !(std::fabs(with - without) <= static_cast<float>(StereoParams{}.surface_step_px));
  }

  const char* name_;
  void (*turn_off_)(StereoParams&);
  std::size_t known_ = 0, valid_ = 0, wrong_ = 0, valid_without_ = 0, wrong_without_ = 0;
  std::vector<double> ratios_;
  std::size_t added_ = 0, on_liquid_ = 0, measured_ = 0, right_ = 0, in_one_ = 0, in_two_ = 0;
};

class RuleScores {
 public:
  void compare(const Pair& pair) {
    for (RuleScore& rule : rules_) rule.compare(pair);
  }
  void print() const {
    for (const RuleScore& rule : rules_) rule.print();
  }

 private:
  std::array<RuleScore, 3> rules_ = {
      RuleScore{"edges", [](StereoParams& p) { p.surface_step_px = 0; }},
      RuleScore{"gaps", [](StereoParams& p) { p.gap_reach_px = 0; }},
      RuleScore{"edges and gaps", [](StereoParams& p) { p.surface_step_px = p.gap_reach_px = 0; }},
  };
};

// --- would another pair help?

/// What the next pair of the strip, whose left image is this one's right, says of this one's disparities.
struct SecondOpinion {
  std::size_t wrong = 0, wrong_flagged = 0, right = 0, right_flagged = 0;

  void compare(const Pair& pair, const Answer& answer, const Pair& next, const Answer& opinion) {
    for (int y = 0; y < pair.left.height; ++y) {
      for (int x = 0; x < pair.left.width; ++x) {
        const auto d = static_cast<double>(answer.disparity.at(x, y)), truth = static_cast<double>(pair.truth.at(x, y));
        if (!std::isfinite(d) || !std::isfinite(truth)) continue;
        const bool is_wrong = std::fabs(d - truth) > pair.bound_px;
        const bool flagged = contradicts(pair, x, y, d, next, opinion);
        (is_wrong ? wrong : right) += 1;
        (is_wrong ? wrong_flagged : right_flagged) += flagged ? 1 : 0;
      }
    }
  }

 private:
  static bool contradicts(const Pair& pair, double x, double y, double disparity, const Pair& next,
                          const Answer& opinion) {
    const RectifiedPair& a = pair.rectified;
    const double z = a.focal_px * a.baseline / (disparity - a.disparity_offset_px());
    if (!(z > 0)) return false;
    const Vec3 in_left =
        a.rect_from_left.transpose() * Vec3((x - a.cx_left) / a.focal_px, (y - a.cy) / a.focal_px, 1) * z;
    const RigidTransform& camera = pair.left_from_world;
    const Vec3 world = camera.rotation.transpose() * (in_left - camera.translation);
    const RectifiedPair& b = next.rectified;
    const Vec3 seen = b.rect_from_left * (next.left_from_world * world);
    if (!(seen.z() > 0)) return false;
    const auto u = static_cast<int>(std::lround(b.focal_px * seen.x() / seen.z() + b.cx_left));
    const auto v = static_cast<int>(std::lround(b.focal_px * seen.y() / seen.z() + b.cy));
    if (u < 0 || v < 0 || u >= opinion.disparity.width || v >= opinion.disparity.height) return false;
    const double expected = b.focal_px * b.baseline / seen.z() + b.disparity_offset_px();
    const auto said = static_cast<double>(opinion.disparity.at(u, v));
    return std::isfinite(said) && std::fabs(said - expected) > 1;
  }
};

struct Row {
  std::string matcher;
  bool has_sigma = false;
  std::vector<Score> scores, textured;
  std::vector<double> milliseconds;
};
using Table = std::vector<Row>;

void compare(const Pair& pair, Table& table) {
  const Gray places = textured_places(pair.left);
  const std::vector<Answer> answers = answers_of_all(pair);
  table.resize(answers.size());
  for (std::size_t i = 0; i < answers.size(); ++i) {
    table[i].matcher = answers[i].matcher;
    table[i].has_sigma = !answers[i].sigma.samples.empty();
    table[i].scores.push_back(score(pair, answers[i], {}));
    table[i].textured.push_back(score(pair, answers[i], places));
    table[i].milliseconds.push_back(1e3 * answers[i].seconds);
  }
}

template <typename Of>
double mean(const std::vector<Score>& scores, Of of) {
  double sum = 0;
  for (const Score& s : scores) sum += of(s);
  return sum / static_cast<double>(scores.size());
}

void print(const std::string& title, const Table& table) {
  std::printf("%s, %zu pairs; the last two columns: textured places only\n%-16s %8s %8s %9s %10s %8s %8s %9s %9s\n",
              title.c_str(), table[0].scores.size(), "", "wrong %", "bad %", "complete", "median px", "locking", "ms",
              "wrong %", "complete");
  for (const Row& row : table) {
    const auto wrong = [](const Score& s) { return s.wrong; };
    const auto complete = [](const Score& s) { return s.complete; };
    std::printf("%-16s %8.3f %8.3f %9.3f %10.3f %8.3f %8.1f %9.3f %9.3f", row.matcher.c_str(),
                100 * mean(row.scores, wrong), 100 * (mean(row.scores, wrong) + 1 - mean(row.scores, complete)),
                100 * mean(row.scores, complete), mean(row.scores, [](const Score& s) { return s.median_px; }),
                mean(row.scores, [](const Score& s) { return s.locking_px; }),
                std::accumulate(row.milliseconds.begin(), row.milliseconds.end(), 0.0) /
                    static_cast<double>(row.milliseconds.size()),
                100 * mean(row.textured, wrong), 100 * mean(row.textured, complete));
    if (row.has_sigma) {
      std::printf("   in 1, 2 sigma: %.2f, %.2f", mean(row.scores, [](const Score& s) { return s.one_sigma; }),
                  mean(row.scores, [](const Score& s) { return s.two_sigma; }));
    }
    std::printf("\n");
  }
}

int run(int argc, char** argv) {
  if (argc > 1 && argv[1][0] == '-') {
    std::printf("stereo-peers [SIMULATED_FLIGHT...]: folders of ilp-sil --out; without any, the Middlebury pairs\n");
    return 2;
  }
  if (argc == 1) {
    constexpr struct {
      const char* name;
      std::int32_t disparities;
    } pairs[] = {{"tsukuba", 16}, {"cones", 64}, {"motorcycle", 64}};
    for (const auto& [name, disparities] : pairs) {
      Pair pair;
      Table table;
      if (!middlebury_pair(name, disparities, pair)) {
        std::printf("skipped: data set stereo_middlebury is absent\n");
        return 77;
      }
      compare(pair, table);
      print(name, table);
      RuleScores rules;
      rules.compare(pair);
      rules.print();
    }
  }
  for (int i = 1; i < argc; ++i) {
    const fs::path flight = fs::path(argv[i]) / "flight";
    Table table;
    SecondOpinion opinion;
    RuleScores rules;
    for (int number = 1; number <= 200 && fs::exists(flight / "images" / (stem(number) + ".pgm")); number += 4) {
      Pair pair, next;
      if (!flight_pair(flight, number, 0.8, pair)) continue;
      compare(pair, table);
      rules.compare(pair);
      if (flight_pair(flight, pair.second, 0.8, next))
        opinion.compare(pair, ours(pair, StereoMatcherChoice::semi_global), next,
                        ours(next, StereoMatcherChoice::semi_global));
    }
    if (table.empty()) throw std::runtime_error(flight.string() + ": no pair of frames with 80 % overlap");
    print(argv[i], table);
    rules.print();
    std::printf("the next pair contradicts %zu of %zu wrong disparities of semi_global and %zu of %zu right ones\n",
                opinion.wrong_flagged, opinion.wrong, opinion.right_flagged, opinion.right);
  }
  return 0;
}

}  // namespace
}  // namespace ilp::peers

int main(int argc, char** argv) {
  try {
    return ilp::peers::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "stereo-peers: %s\n", error.what());
    return 1;
  }
}
