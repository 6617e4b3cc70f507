#include "fsw/vision/map/map_registration.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/vision/map/ground_point.hpp"
#include "fsw/vision/map/map_channels.hpp"
#include "fsw/vision/map/map_pose.hpp"
#include "fsw/vision/map/patch_search.hpp"

namespace ilp {
namespace {

constexpr std::int32_t rows_at_once = 32;
constexpr std::int64_t products_at_once = 6'000'000;  // of a slice
constexpr std::int32_t place_reach_px = 3;            // of a patch's own place from that of all
constexpr std::size_t least_places = 6;
constexpr double sanity_sigmas = 4;    // of the prior, by which rotation and height may differ from it
constexpr double senses_agree_px = 3;  // of relit and shape, where both have a verdict

/// What the heights do not resolve lies on one side of them in the light, and depths of a keyframe err together.
MapPoseParams pose_params(MapSense sense, double pixel_m, double sigma_px) {
  MapPoseParams params;
  params.pixel_m = pixel_m;
  params.sigma_px = sigma_px;
  if (sense == MapSense::shape) {
    params.together = 1.55;
    params.common_share = 0;
    params.common_growth = 0.4;
  } else if (sense == MapSense::relief) {
    params.together = 1.5;
  }
  return params;
}

/// Heights and shadings are smooth, so that chance agrees more often. Small patches need what grey says beside its
/// directions.
PatchSearch search_of(MapSense sense, const MapPlan& plan) {
  if (sense != MapSense::relit) return {plan.patch_px, 0.5F};
  return {plan.patch_px, plan.patch_px <= map_least_patch_px ? 1.0F : 0.0F};
}

/// Middle of a patch, in cells of the window from the centre of its first one, where it was drawn.
Vec2 middle_cell(std::int32_t column, std::int32_t row, const MapPlan& plan) {
  const double half = 0.5 * (plan.patch_px - 1);
  return {plan.sheet_column + column + half, plan.sheet_row + row + half};
}

/// Blocks of two by two patches, as on a chessboard: each half has all four quarters.
bool is_of_other_half(const MapPatch& patch, std::int32_t side) {
  return (patch.column / side / 2 + patch.row / side / 2) % 2 != 0;
}

MapKeyframe moved(MapKeyframe keyframe, const RigidTransform& by_prior) {
  keyframe.camera_from_map = compose(keyframe.camera_from_map, by_prior);
  return keyframe;
}

Vec3 place_at(const MapWindow& window, double column, double row) {
  Vec3 place(window.x0_m + (column + 0.5) * window.pixel_m, window.y0_m - (row + 0.5) * window.pixel_m, 0);
  place.z() = height_at(window, place.x(), place.y());
  return place;
}

}  // namespace

Status MapRegistration::check() const {
  const MapWindow& window = input_.window;
  const MapPlan& plan = input_.plan;
  const bool sized = window.width >= 2 && window.height >= 2 && window.width <= max_map_window_side &&
                     window.height <= max_map_window_side && window.width == plan.width && window.height == plan.height;
  if (!sized) return out_of_range(Argument::map_window, window.width);
  const bool planned = plan.search_px > map_edge_px && plan.search_px <= max_map_shift_px && plan.sheet_width > 0 &&
                       plan.sheet_height > 0 && plan.sheet_width <= max_map_sheet_side &&
                       plan.sheet_height <= max_map_sheet_side && plan.width == plan.sheet_width + 2 * plan.search_px &&
                       plan.height == plan.sheet_height + 2 * plan.search_px && plan.patch_px >= 4 &&
                       plan.patch_px <= max_map_patch_side && plan.patch_px % 2 == 0;
  if (!planned) return out_of_range(Argument::map_window, plan.search_px);
  if (!(window.pixel_m > 0) || !std::isfinite(window.pixel_m + window.x0_m + window.y0_m + window.ground_m)) {
    return out_of_range(Argument::map_window, window.pixel_m);
  }
  if (window.height_m == nullptr || window.known == nullptr) return out_of_range(Argument::map_window);
  if (input_.keyframes.empty()) return out_of_range(Argument::map_keyframe);
  for (const MapKeyframe& keyframe : input_.keyframes) {
    if (!keyframe.camera_from_map.rotation.allFinite() || !keyframe.camera_from_map.translation.allFinite()) {
      return out_of_range(Argument::map_keyframe);
    }
  }
  const bool prior = input_.prior.covariance.allFinite() && input_.prior.camera_from_map.rotation.allFinite() &&
                     input_.prior.camera_from_map.translation.allFinite();
  return prior ? Status() : out_of_range(Argument::map_keyframe);
}

void MapRegistration::choose_senses() {
  sense_count_ = 0;
  if (input_.depths != nullptr) {
    if (has_heights_) senses_[sense_count_++] = MapSense::relief;
    return;
  }
  const bool near = azimuth_between(input_.sun.azimuth_rad, input_.window.sun_azimuth_rad) < params_.sun_limit_rad;
  if (params_.use_relit && near && input_.window.image != nullptr) senses_[sense_count_++] = MapSense::relit;
  if (params_.use_shape && has_heights_) senses_[sense_count_++] = MapSense::shape;
}

SheetSums MapRegistration::sums() const {
  return {input_.plan.sheet_width, input_.plan.sheet_height, workspace_->sums.data(), workspace_->sheet_count.data()};
}

Status MapRegistration::begin(const MapRegistrationInput& input, const MapRegistrationParams& params,
                              MapRegistrationWorkspace& workspace) {
  input_ = input;
  params_ = params;
  workspace_ = &workspace;
  phase_ = Phase::done;
  result_ = {};
  for (Candidate& candidate : candidates_) candidate = {};
  again_ = false;
  by_prior_ = {};
  input_.plan.sheet_column = input_.plan.sheet_row = input_.plan.search_px;
  ILP_TRY(check());
  const MapWindow& window = input_.window;
  const std::size_t cells = static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height);
  for (std::size_t k = 0; k < cells; ++k) {
    if (!std::isfinite(window.height_m[k])) return out_of_range(Argument::map_window, k);
  }
  level_m_ = window.ground_m;
  has_heights_ = mean_height(window, level_m_);
  input_.window.ground_m = level_m_;
  lighting_ = {lamp_of(input_.sun, params_.ambient),
               lamp_of({window.sun_azimuth_rad, window.sun_elevation_rad}, params_.ambient)};
  choose_senses();
  if (sense_count_ == 0) return {};
  sense_ = 0;
  return begin_drawing();
}

Status MapRegistration::begin_drawing() {
  const auto cells = input_.plan.sheet_width * input_.plan.sheet_height;
  std::fill_n(workspace_->sums.begin(), cells, 0);
  std::fill_n(workspace_->sheet_count.begin(), cells, std::uint8_t{0});
  keyframe_ = 0;
  ILP_TRY(begin_sheet());
  phase_ = Phase::sheet;
  return {};
}

Status MapRegistration::begin_sheet() {
  row_ = 0;
  if (input_.depths != nullptr) return {};
  return painter_.begin(moved(input_.keyframes[keyframe_], by_prior_), input_.plan, input_.window, level_m_);
}

Status MapRegistration::draw_sheet() {
  const bool relief = input_.depths != nullptr;
  const std::int32_t rows = relief ? input_.depths->depth_m.height : input_.plan.sheet_height;
  const std::int32_t last = std::min(row_ + rows_at_once, rows);
  if (relief) {
    add_depths(moved(input_.keyframes[0], by_prior_), input_.depths->depth_m, input_.depths->first_px,
               input_.depths->step_px, input_.plan, level_m_, row_, last, sums());
  } else {
    painter_.paint_rows(input_.window, row_, last, sums());
  }
  row_ = last;
  if (row_ < rows) return {};
  ++keyframe_;
  if (!relief && keyframe_ < input_.keyframes.size()) return begin_sheet();
  phase_ = Phase::sheet_channels;
  return {};
}

void MapRegistration::prepare_sheet() {
  finish_sheet(sums(), workspace_->sheet);
  MapChannels<max_map_sheet_side>& sheet = workspace_->sheet;
  fill_directions(sheet, mean_gradient(sheet), 0, sheet.height);
  patches_ = choose_patches(sheet, input_.plan.patch_px, *workspace_);
  if (sense() == MapSense::shape) hide_dark_cells(painter_.darkest_lit(), sheet);
  sheet_scale_ = normalise_values(sheet.value.data(), sheet.at(0, sheet.height));
  row_ = 0;
  phase_ = Phase::window;
}

void MapRegistration::fill_window() {
  MapChannels<max_map_window_side>& channels = workspace_->window;
  const MapWindow& window = input_.window;
  channels.width = window.width;
  channels.height = window.height;
  const std::int32_t last = std::min(row_ + rows_at_once, window.height);
  switch (sense()) {
    case MapSense::relit:
      relight_rows(window, lighting_, row_, last, channels);
      break;
    case MapSense::shape:
      shade_rows(window, lighting_, row_, last, channels);
      break;
    default:
      height_rows(window, level_m_, row_, last, channels);
      break;
  }
  row_ = last;
  if (row_ < window.height) return;
  soft_ = mean_gradient(channels);
  row_ = 0;
  phase_ = Phase::window_channels;
}

void MapRegistration::prepare_window() {
  MapChannels<max_map_window_side>& channels = workspace_->window;
  const std::int32_t last = std::min(row_ + rows_at_once, channels.height);
  fill_directions(channels, soft_, row_, last);
  row_ = last;
  if (row_ < channels.height) return;
  (void)normalise_values(channels.value.data(), channels.at(0, channels.height));
  patch_ = 0;
  if (again_) {
    phase_ = Phase::points;
    return;
  }
  VoteSurfaces(*workspace_, lags()).clear();
  known_lags_ = 0;
  textured_ = 0;
  phase_ = Phase::patches;
}

void MapRegistration::search_patches() {
  const PatchSearch how = search_of(sense(), input_.plan);
  const std::int32_t side = lags();
  const std::int64_t products = std::int64_t{side} * side * how.side * how.side * (how.value_share > 0 ? 3 : 2);
  VoteSurfaces surfaces(*workspace_, side);
  std::int64_t work = 0;
  // Where the first sense has a verdict, the second one controls it with half of the patches.
  const bool controls = sense_ > 0 && candidates_[0].vote.verdict == MapVerdict::fixed;
  for (; patch_ < patches_ && work < products_at_once; ++patch_) {
    MapPatch& patch = workspace_->patches[static_cast<std::size_t>(patch_)];
    patch.used = false;
    if (controls && is_of_other_half(patch, how.side)) continue;
    patch.used = has_texture(workspace_->sheet, patch, how);
    if (!patch.used) continue;
    ++textured_;
    search_patch(patch, how, {0, 0, side, side}, *workspace_);
    const std::int32_t known = surfaces.add(patch);
    patch.used = known > 0;
    known_lags_ += known;
    work += products;
  }
  if (patch_ >= patches_) count();
}

void MapRegistration::count() {
  Candidate& candidate = candidates_[sense_];
  candidate.sense = sense();
  const std::span<const MapPatch> patches(workspace_->patches.data(), static_cast<std::size_t>(patches_));
  const auto used = std::count_if(patches.begin(), patches.end(), [](const MapPatch& p) { return p.used; });
  const double mean_lags = used > 0 ? static_cast<double>(known_lags_) / static_cast<double>(used) : 1;
  candidate.vote = count_votes(patches, VoteSurfaces(*workspace_, lags()), lags(), mean_lags, params_.min_evidence);
  if (candidate.vote.verdict == MapVerdict::no_texture && textured_ > candidate.vote.patches) {
    candidate.vote.verdict = MapVerdict::no_map;
  }
  if (candidate.vote.verdict != MapVerdict::fixed) {
    next_sense();
    return;
  }
  patch_ = 0;
  phase_ = Phase::points;
}

void MapRegistration::place_patches() {
  Candidate& candidate = candidates_[sense_];
  const PatchSearch how = search_of(sense(), input_.plan);
  constexpr std::int32_t reach = place_reach_px + 1, side = 2 * reach + 1;  // with neighbours of the farthest place
  const LagRange near{candidate.vote.column - reach, candidate.vote.row - reach, side, side};
  candidate.places.clear();
  for (; patch_ < patches_; ++patch_) {
    MapPatch& patch = workspace_->patches[static_cast<std::size_t>(patch_)];
    if (again_) patch.used = has_texture(workspace_->sheet, patch, how);
    if (!patch.used) continue;
    search_patch(patch, how, near, *workspace_);
    const auto score = [&](std::int32_t column, std::int32_t row) {
      return workspace_->surface[static_cast<std::size_t>(row) * map_lag_stride + static_cast<std::size_t>(column)];
    };
    std::int32_t column = 1, row = 1;
    for (std::int32_t r = 1; r < side - 1; ++r) {
      for (std::int32_t c = 1; c < side - 1; ++c) {
        if (score(c, r) <= score(column, row)) continue;
        column = c;
        row = r;
      }
    }
    if (column == 1 || row == 1 || column == side - 2 || row == side - 2) continue;
    const double fine_column = vertex(score(column - 1, row), score(column, row), score(column + 1, row));
    const double fine_row = vertex(score(column, row - 1), score(column, row), score(column, row + 1));
    (void)candidate.places.push_back(
        {patch.column, patch.row,
         static_cast<float>(near.first_column + column + fine_column - input_.plan.sheet_column),
         static_cast<float>(near.first_row + row + fine_row - input_.plan.sheet_row)});
  }
  if (again_) {
    phase_ = Phase::done;
    (void)fix(candidate);
  } else {
    next_sense();
  }
}

void MapRegistration::next_sense() {
  row_ = 0;
  phase_ = ++sense_ < sense_count_ ? Phase::window : Phase::conclude;
}

Status MapRegistration::conclude() {
  phase_ = Phase::done;
  const Candidate* best = &candidates_[0];
  for (const Candidate& candidate : std::span(candidates_).first(sense_count_)) {
    const bool fixed = candidate.vote.verdict == MapVerdict::fixed,
               best_fixed = best->vote.verdict == MapVerdict::fixed;
    if (fixed > best_fixed || (fixed == best_fixed && candidate.vote.evidence > best->vote.evidence)) best = &candidate;
  }
  const MapVote& vote = best->vote;
  result_.sense = best->sense;
  result_.verdict = vote.verdict;
  result_.evidence = vote.evidence;
  result_.patches = vote.patches;
  result_.votes = vote.votes;
  result_.rivals = vote.rivals;
  result_.quarters = vote.quarters;
  result_.shift_px[0] = vote.fine_column - input_.plan.search_px;
  result_.shift_px[1] = vote.fine_row - input_.plan.search_px;
  if (vote.verdict != MapVerdict::fixed) return {};
  for (const Candidate& candidate : std::span(candidates_).first(sense_count_)) {
    const double dx = candidate.vote.fine_column - vote.fine_column, dy = candidate.vote.fine_row - vote.fine_row;
    const bool agrees = dx * dx + dy * dy <= senses_agree_px * senses_agree_px;
    if (candidate.vote.verdict == MapVerdict::fixed && !agrees) result_.verdict = MapVerdict::senses_contradict;
  }
  if (result_.verdict != MapVerdict::fixed) return {};
  if (!fix(*best)) result_.verdict = MapVerdict::no_agreement;
  if (result_.verdict != MapVerdict::fixed) return {};
  sense_ = static_cast<std::size_t>(best - candidates_.data());
  // The image tells repetitions of heights apart.
  if (candidates_[0].sense == MapSense::relit && candidates_[0].vote.verdict == MapVerdict::fixed)
    return search_again();
  MapPlan found = input_.plan;
  found.sheet_column = vote.column;
  found.sheet_row = vote.row;
  repeats_.begin(input_.window, level_m_, found, *workspace_);
  phase_ = Phase::repeats;
  return {};
}

/// What the prior had wrong, tilt over relief most of all, distorts the patches: the sheet is drawn once more, by the
/// pose that was found.
Status MapRegistration::search_again() {
  again_ = true;
  by_prior_ = compose(inverse(input_.prior.camera_from_map), level_pose_);
  const MapVote& vote = candidates_[sense_].vote;
  input_.plan.sheet_column = vote.column;
  input_.plan.sheet_row = vote.row;
  return begin_drawing();
}

bool MapRegistration::fix(const Candidate& candidate) {
  const MapWindow& window = input_.window;
  const MapPrior& prior = input_.prior;
  std::array<MapSighting, max_map_patches> all;
  std::size_t count = 0;
  const RigidTransform camera_from_drawn = compose(prior.camera_from_map, by_prior_);
  for (const auto& place : candidate.places) {
    const Vec2 middle = middle_cell(place.column, place.row, input_.plan);
    Vec3 drawn_at = place_at(window, middle.x(), middle.y());
    if (candidate.sense == MapSense::relief) drawn_at.z() = own_height(place);
    const Vec3 seen = camera_from_drawn * drawn_at;
    if (!(seen.z() > 0)) continue;
    all[count].at = Vec2(seen.x() / seen.z(), seen.y() / seen.z());
    all[count].place = place_at(window, middle.x() + static_cast<double>(place.shift_column_px),
                                middle.y() + static_cast<double>(place.shift_row_px));
    ++count;
  }
  const std::span<MapSighting> sightings(all.data(), count);
  MapPose pose, level;
  if (count < least_places) return false;
  const MapPoseParams params = pose_params(candidate.sense, window.pixel_m, params_.patch_sigma_px);
  // The ground by the attitude that is expected as well: few patches tell a tilt badly, and it takes their middle with
  // it. An attitude that earlier fixes say is no part of the pose, whose attitude says more to those that follow.
  MapPrior attitude = prior;
  attitude.attitude_is_measured = true;
  if (!solve_map_pose(sightings, attitude, params, level)) return false;
  if (prior.attitude_is_measured) {
    pose = level;
  } else if (!solve_map_pose(sightings, prior, params, pose)) {
    return false;
  }
  level_pose_ = level.camera_from_map;
  Vec3 ground, expected;
  if (!ground_on_axis(level_pose_, window, level_m_, ground) ||
      !ground_on_axis(prior.camera_from_map, window, level_m_, expected)) {
    return false;
  }
  result_.camera_from_map = pose.camera_from_map;
  result_.covariance = pose.covariance;
  result_.residual_px = pose.residual_px;
  result_.ground_m[0] = ground.x();
  result_.ground_m[1] = ground.y();
  result_.ground_m[2] = height_at(window, ground.x(), ground.y());
  result_.ground_covariance = ground_covariance(level_pose_, ground, level.covariance);
  const Vec2 shift = (ground - expected).head<2>();
  const Mat2 expected_covariance = ground_covariance(prior.camera_from_map, expected, prior.covariance);
  const double determinant = expected_covariance.determinant();
  if (determinant > 0) {
    result_.shift_sigmas = std::sqrt((expected_covariance(1, 1) * shift.x() * shift.x() +
                                      expected_covariance(0, 0) * shift.y() * shift.y() -
                                      2 * expected_covariance(0, 1) * shift.x() * shift.y()) /
                                     determinant);
  }
  take_points(sightings);
  result_.verdict = is_sane(sightings, params) ? MapVerdict::fixed : MapVerdict::contradicts_prior;
  return true;
}

double MapRegistration::own_height(const Candidate::Place& place) const {
  const std::int32_t half = input_.plan.patch_px / 2;
  const std::int16_t value = workspace_->sheet.value[workspace_->sheet.at(place.column + half, place.row + half)];
  const double raw =
      sheet_scale_.mean +
      (value == unknown_value || !(sheet_scale_.scale > 0) ? 0 : static_cast<double>(value) / sheet_scale_.scale);
  return level_m_ + height_of_raw(raw, input_.plan.pixel_m);
}

bool MapRegistration::is_sane(std::span<const MapSighting> sightings, const MapPoseParams& params) const {
  const auto agrees = [&](const RigidTransform& pose, const PoseCovariance& covariance) {
    const Eigen::Matrix<double, 6, 1> change = pose_change(input_.prior.camera_from_map, pose);
    const PoseCovariance sum = input_.prior.covariance + covariance;
    for (const int k : {0, 1, 2, 5}) {
      if (!(change(k) * change(k) <= sanity_sigmas * sanity_sigmas * sum(k, k))) return false;
    }
    return true;
  };
  if (!agrees(result_.camera_from_map, result_.covariance)) return false;
  // What the places say by themselves: an attitude that is measured would hide that the map is turned.
  std::array<MapSighting, max_map_patches> copy;
  const std::size_t count = std::min(sightings.size(), copy.size());
  std::copy_n(sightings.begin(), count, copy.begin());
  MapPrior prior = input_.prior;
  prior.attitude_is_measured = false;
  MapPose alone;
  return !solve_map_pose(std::span(copy.data(), count), prior, params, alone) ||
         agrees(alone.camera_from_map, alone.covariance);
}

void MapRegistration::take_points(std::span<const MapSighting> sightings) {
  const CameraModel& camera = input_.keyframes[0].camera;
  const MapWindow& window = input_.window;
  result_.points.clear();
  const auto used = static_cast<std::size_t>(
      std::count_if(sightings.begin(), sightings.end(), [](const MapSighting& s) { return s.weight > 0; }));
  const std::size_t wanted = std::min(used, limits::max_fix_points);
  std::size_t seen = 0;
  for (const MapSighting& sighting : sightings) {
    if (!(sighting.weight > 0)) continue;
    // Evenly spread ones of those that are more than fit.
    if (seen++ * wanted < result_.points.size() * used) continue;
    MapFixPoint point;
    point.u_px = static_cast<float>(camera.fx * sighting.at.x() + camera.cx);
    point.v_px = static_cast<float>(camera.fy * sighting.at.y() + camera.cy);
    point.column_px = static_cast<float>((sighting.place.x() - window.x0_m) / window.pixel_m - 0.5);
    point.row_px = static_cast<float>((window.y0_m - sighting.place.y()) / window.pixel_m - 0.5);
    point.height_m = static_cast<float>(sighting.place.z());
    point.residual_px = static_cast<float>(sighting.residual.norm());
    if (!result_.points.push_back(point)) return;
  }
}

Result<bool> MapRegistration::step() {
  switch (phase_) {
    case Phase::sheet:
      ILP_TRY(draw_sheet());
      break;
    case Phase::sheet_channels:
      prepare_sheet();
      break;
    case Phase::window:
      fill_window();
      break;
    case Phase::window_channels:
      prepare_window();
      break;
    case Phase::patches:
      search_patches();
      break;
    case Phase::points:
      place_patches();
      break;
    case Phase::conclude:
      ILP_TRY(conclude());
      break;
    case Phase::repeats:
      if (repeats_.step(*workspace_)) break;
      if (!repeats_.repeats()) {
        ILP_TRY(search_again());
      } else {
        result_.verdict = MapVerdict::ambiguous;
        phase_ = Phase::done;
      }
      break;
    case Phase::done:
      break;
  }
  return phase_ != Phase::done;
}

}  // namespace ilp
