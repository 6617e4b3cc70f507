#include "fsw/localisation/map_fix.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/localisation/map_prior.hpp"
#include "fsw/localisation/map_start.hpp"
#include "fsw/localisation/sun.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/shared/frame_access.hpp"
#include "fsw/shared/local_plane.hpp"
#include "fsw/shared/measured_keyframe.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr std::int64_t keyframes_about = 16;  // whose measurements say where a strip is
constexpr std::int64_t most_tiles = 64;       // under one window
constexpr double edge_px = map_edge_px;
// The parameter map_senses.
constexpr std::uint8_t sense_relit = 1, sense_shape = 2, sense_relief = 4;

void copy(const Vec3& from, double (&to)[3]) {
  for (int i = 0; i < 3; ++i) to[i] = from[i];
}

/// The registration found the ground elsewhere, so that the place may be lost. No agreement is none: ground without
/// texture, or under another sun.
bool is_failure(MapVerdict verdict) {
  return verdict == MapVerdict::at_edge || verdict == MapVerdict::contradicts_prior;
}

std::size_t cell_count(const SeenCells& cells) {
  return static_cast<std::size_t>(cells.columns) * static_cast<std::size_t>(cells.rows);
}

std::uint16_t coded(double value) {
  return static_cast<std::uint16_t>(std::clamp(std::floor(value + 0.5), 0.0, 65535.0));
}

FixPoint point_of(const MapFixPoint& point) {
  return {coded((static_cast<double>(point.u_px) + fix_point_margin_px) * fix_points_per_px),
          coded((static_cast<double>(point.v_px) + fix_point_margin_px) * fix_points_per_px),
          coded(static_cast<double>(point.column_px) * fix_window_points_per_px),
          coded(static_cast<double>(point.row_px) * fix_window_points_per_px)};
}

MapRegistrationParams params_of(const MissionParameters& mission, const MapDirectory& map) {
  MapRegistrationParams params;
  params.sun_limit_rad = mission.map_sun_limit_rad;
  params.ambient = map.ambient;
  params.min_evidence = mission.map_evidence;
  params.patch_sigma_px = mission.map_sigma_px;
  params.use_relit = (mission.map_senses & sense_relit) != 0;
  params.use_shape = (mission.map_senses & sense_shape) != 0;
  return params;
}

}  // namespace

constexpr CheckpointForm MapFix::checkpoint = checkpoint_form<State>(component_id);

MapFix::MapFix(Tables store, const MissionParameters& mission, Scratch scratch, MapSource* source)
    : wiring_{store, mission, source, scratch} {}

Status MapFix::restore() {
  work_.phase = Phase::open;
  work_.keeps = false;
  work_.usable = false;
  const Status status = restore_checkpoint(wiring_.store, checkpoint, cursor_, state_);
  if (!restored(status)) return status;
  std::int64_t newest = 0;
  ILP_TRY(newest_id<FixRecord>(wiring_.store, newest));
  // Other components have used the records: they are not made again.
  cursor_.first = std::max(cursor_.first, newest);
  return status;
}

LastingMemory MapFix::lasting() const {
  const LastingMemory memory =
      LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_).changed_by_commits();
  if (!work_.keeps) return memory;
  if (work_.phase == Phase::search) return memory.keeping(wiring_.scratch.as<MapFixScratch>().registration);
  if (work_.phase != Phase::start_features) return memory;
  const auto& place = wiring_.scratch.as<MapStartScratch>().place;
  return memory.keeping(place.harris.progress).keeping(place.features.progress);
}

Result<bool> MapFix::pick() {
  ILP_TAKE(const Found found, find_next(wiring_.store, cursor_.first, work_.depth));
  if (found == Found::nothing) return false;
  work_.record = {};
  work_.points.clear();
  work_.record.id = work_.depth.id;
  work_.record.strip_id = work_.depth.strip_id;
  work_.pose = {};
  work_.pose.state = PoseState::failed;
  work_.scale = work_.scale_sigma = 0;
  work_.relief = false;
  work_.layer = 0;
  work_.painted = 0;
  workspace_.after = state_;
  workspace_.keyframe = {};
  const bool bare = found == Found::damaged || work_.patience.abandoned(work_.depth.id);
  work_.phase = bare ? Phase::record : Phase::load;
  return true;
}

/// The map may have come since the keyframe before, or another one may lie there.
Status MapFix::load() {
  if (!work_.usable || wiring_.source->directory_mark() != work_.directory_mark) part().open();
  work_.phase = Phase::record;
  if (!work_.usable) return {};
  const MapDirectory& map = workspace_.directory;
  FixRecord& record = work_.record;
  record.map_id = static_cast<std::int64_t>(map.id);
  record.body = map.body;
  record.map_longitude_deg = part().origin().longitude_deg;
  record.map_latitude_deg = part().origin().latitude_deg;
  record.map_sigma_m = map.place_sigma_m;
  // Fixes on another map, or in the world of another strip, say nothing here.
  MapState& after = workspace_.after;
  if (after.map_id != record.map_id || after.book.strip_id != record.strip_id) {
    after.book = {};
    after.strip.clear();
  }
  after.map_id = record.map_id;
  after.book.strip_id = record.strip_id;
  ILP_TAKE(const bool posed, find(wiring_.store, record.id, work_.pose));
  if (!posed || work_.pose.state != PoseState::final) work_.pose.state = PoseState::failed;
  KeyframeRecord keyframe;
  ILP_TAKE(const bool known, find(wiring_.store, record.id, keyframe));
  if (work_.pose.state != PoseState::final || !known) return {};
  work_.time_ns = keyframe.time_ns;
  ILP_TRY(measure());
  if (keyframe.index % wiring_.mission.map_every_keyframes != 0) return {};
  MapFixScratch& memory = scratch();
  ILP_TRY(load_camera(wiring_.store, memory.keyframe.camera));
  // An image that was released is no fault.
  ILP_TAKE(const bool seen, found_by(load_keyframe_image(wiring_.store, record.id, memory.image)));
  if (!seen) return {};
  ILP_TRY(load_depths());
  memory.keyframe.image = memory.image.view();
  work_.keeps = true;
  work_.phase = Phase::survey;
  return {};
}

/// Inverse depths of cells, and the depth of the ground point.
Status MapFix::load_depths() {
  MapFixScratch& memory = scratch();
  const CameraModel& camera = memory.keyframe.camera;
  ILP_TRY(clear_seen_cells(camera.width, camera.height, memory.seen));
  const std::size_t cells = cell_count(memory.seen);
  memory.inverse_depth.fill(0);
  if (work_.depth.cells.bytes != cells * (1 + sizeof(float))) return {};
  const std::span<std::uint8_t> octets(reinterpret_cast<std::uint8_t*>(memory.inverse_depth.data()),
                                       cells * sizeof(float));
  ILP_TRY(read_blob<DepthRecord>(wiring_.store, "cells", work_.depth.id, cells, octets));
  const std::int32_t column = static_cast<std::int32_t>(camera.cx) / seen_cell_px;
  const std::int32_t row = static_cast<std::int32_t>(camera.cy) / seen_cell_px;
  double sum = 0, count = 0;
  for (std::int32_t y = std::max(row - 1, 0); y <= std::min(row + 1, memory.seen.rows - 1); ++y) {
    for (std::int32_t x = std::max(column - 1, 0); x <= std::min(column + 1, memory.seen.columns - 1); ++x) {
      const float inverse =
          memory.inverse_depth[static_cast<std::size_t>(y) * static_cast<std::size_t>(memory.seen.columns) +
                               static_cast<std::size_t>(x)];
      if (!(inverse > 0)) continue;
      sum += static_cast<double>(inverse);
      ++count;
    }
  }
  if (!(count > 0)) return {};
  constexpr double relief_share = 0.01;
  work_.record.ground_depth = count / sum;
  const double share = std::max(work_.depth.pose_sigma, relief_share);
  work_.record.ground_depth_sigma = share * work_.record.ground_depth;
  return {};
}

/// What the vehicle and the images say at this keyframe, and at those about it.
Status MapFix::measure() {
  const BodyPlace origin = part().origin();
  const Body body = workspace_.directory.body;
  workspace_.near.clear();
  for (std::int64_t id = std::max<std::int64_t>(work_.pose.id - keyframes_about + 1, 1); id <= work_.pose.id; ++id) {
    PoseRecord pose;
    NavigationRecord measured;
    ILP_TAKE(const bool posed, find(wiring_.store, id, pose));
    ILP_TAKE(const bool known, find(wiring_.store, id, measured));
    if (!posed || pose.state != PoseState::final || pose.strip_id != work_.pose.strip_id) continue;
    if (!known) measured = {};
    workspace_.keyframe = measured_keyframe(pose, measured, body, origin);
    if (has_place(measured, body)) plane_from_place(body, origin, place_of(measured), workspace_.keyframe.place_m);
    static_cast<void>(workspace_.near.push_back(workspace_.keyframe));
  }
  return {};
}

/// `by_vehicle` may know the length of the strip's unit better than a few fixes do.
void MapFix::predict_by_fixes(const navigation::StripFrame& by_vehicle) {
  FixBook& book = workspace_.after.book;
  // A fix that waits for a second one leads to it, where no others do.
  const bool by_unconfirmed = book.fixes.empty() && book.has_unconfirmed != 0;
  if (book.fixes.empty() && !by_unconfirmed) return;
  if (by_unconfirmed) static_cast<void>(book.fixes.push_back(book.unconfirmed));
  const navigation::StripFrame frame = frame_by_fixes(book, workspace_.near);
  const Vec3 way = vector_of(work_.pose.centre) - vector_of(book.fixes.back().centre);
  if (by_unconfirmed) book.fixes.clear();
  if (!prior_by_fixes(frame, work_.pose, frame.metres_per_unit * way.norm(), work_.prior)) return;
  work_.record.prior = FixPrior::fixes;
  const bool better = by_vehicle.scale_sigma > 0 && by_vehicle.scale_sigma < frame.scale_sigma;
  work_.scale = better ? by_vehicle.metres_per_unit : frame.metres_per_unit;
  work_.scale_sigma = better ? by_vehicle.scale_sigma : frame.scale_sigma;
}

/// False where the vehicle says too little.
bool MapFix::predict_by_vehicle(const navigation::StripFrame& frame) {
  Vec3 place = Vec3::Zero();
  double sigma = 0;
  if (!place_by_vehicle(frame, workspace_.keyframe, place, sigma) || !find_ground(place)) return false;
  if (!prior_by_vehicle(frame, workspace_.keyframe, work_.ground_m, work_.prior)) return false;
  work_.record.prior = FixPrior::vehicle;
  work_.scale = frame.scale_sigma > 0 ? frame.metres_per_unit : 0;
  work_.scale_sigma = frame.scale_sigma;
  const bool one = !(work_.scale > 0) && workspace_.keyframe.height_sigma_m > 0 && work_.pose.ground_distance > 0;
  if (one) {
    work_.scale = workspace_.keyframe.height_m / work_.pose.ground_distance;
    const double of_height = workspace_.keyframe.height_sigma_m / workspace_.keyframe.height_m;
    const double of_ground = work_.pose.ground_distance_sigma / work_.pose.ground_distance;
    work_.scale_sigma = std::sqrt(of_height * of_height + of_ground * of_ground);
  }
  return true;
}

/// The height of the map's ground below a place.
bool MapFix::find_ground(const Vec3& place) {
  const std::size_t entry = part().coarsest_tile_at(place.x(), place.y());
  if (entry >= limits::max_map_tiles) return false;
  const MapTile* const tile = part().tile(entry);
  const MapLayer& layer = workspace_.directory.layers[workspace_.directory.tiles[entry].layer];
  return tile != nullptr && tile_height(*tile, layer, place.x(), place.y(), work_.ground_m);
}

/// What leads to the place, and the ground there.
Status MapFix::survey() {
  work_.keeps = true;
  const bool searched = work_.record.prior == FixPrior::search;
  const navigation::StripFrame frame = navigation::estimate_strip_frame(workspace_.near);
  if (!searched) predict_by_fixes(frame);
  bool known = work_.record.prior != FixPrior::none;
  if (known) {
    const Vec3 place = camera_centre(work_.prior.camera_from_map);
    known = find_ground(place);
    // The search knows the height above the ground.
    if (searched)
      work_.prior.camera_from_map.translation -= work_.prior.camera_from_map.rotation.col(2) * work_.ground_m;
  } else if (predict_by_vehicle(frame)) {
    known = true;
  } else if (!(workspace_.keyframe.horizontal_sigma_m > 0) && !(frame.horizontal_sigma_m > 0)) {
    workspace_.after.lost = 1;
    MapStart(wiring_, work_, workspace_).begin();
    return {};
  }
  if (known) {
    work_.phase = Phase::plan;
  } else {
    conclude(MapVerdict::no_map);
  }
  return {};
}

Status MapFix::plan() {
  work_.keeps = true;
  MapFixScratch& memory = scratch();
  memory.keyframe.camera_from_map = work_.prior.camera_from_map;
  const double image_m = image_pixel_m(memory.keyframe.camera, work_.prior.camera_from_map, work_.ground_m);
  const Vec3 centre = camera_centre(work_.prior.camera_from_map);
  if (!(image_m > 0)) {
    conclude(MapVerdict::no_map);
    return {};
  }
  work_.layer = part().layer_for(image_m, centre.x(), centre.y());
  const MapLayer& layer = workspace_.directory.layers[work_.layer];
  double pixel = work_.relief ? map_relief_pixel_m(image_m, layer.pixel_m)
                              : map_working_pixel_m(memory.keyframe.camera, image_m, layer.pixel_m);
  Result<MapPlan> planned = plan_map_window({&memory.keyframe, 1}, work_.prior, work_.ground_m, pixel);
  if (planned.status().is(StatusCode::capacity_exceeded)) {
    // A place that is known so badly is sought with coarser pixels first.
    pixel *= 2;
    planned = plan_map_window({&memory.keyframe, 1}, work_.prior, work_.ground_m, pixel);
  }
  const bool searchable = planned.ok() && planned.value().search_px <= wiring_.mission.map_search_px + edge_px;
  const bool too_far = planned.ok() ? !searchable : planned.status().is(StatusCode::capacity_exceeded);
  if (work_.relief && !searchable) {
    // Then the record tells of the light.
    conclude(work_.record.verdict);
    return {};
  }
  if (too_far) {
    workspace_.after.lost = 1;
    if (work_.record.prior == FixPrior::vehicle) {
      MapStart(wiring_, work_, workspace_).begin();
    } else {
      conclude(MapVerdict::at_edge);
    }
    return {};
  }
  if (!planned.ok()) {
    conclude(MapVerdict::no_map);
    return {};
  }
  work_.plan = planned.value();
  part().plan_together(pixel / image_m);
  if (work_.relief) work_.plan.patch_px = map_relief_patch_px;
  work_.tiles = tiles_under(work_.plan, layer);
  work_.painted = 0;
  if (work_.tiles.count() == 0 || work_.tiles.count() > most_tiles || pixel > most_canvas_ratio * layer.pixel_m) {
    conclude(work_.relief ? work_.record.verdict : MapVerdict::no_map);
    return {};
  }
  begin_canvas(work_.plan, memory.canvas);
  work_.phase = Phase::paint;
  return {};
}

/// One tile in each step.
Status MapFix::paint() {
  work_.keeps = true;
  const MapLayer& layer = workspace_.directory.layers[work_.layer];
  const std::int64_t columns = std::int64_t{work_.tiles.last_column} - work_.tiles.first_column + 1;
  const auto row = static_cast<std::int32_t>(work_.tiles.first_row + work_.painted / columns);
  const auto column = static_cast<std::int32_t>(work_.tiles.first_column + work_.painted % columns);
  const MapTile* const tile = part().tile(find_map_tile(workspace_.directory, work_.layer, row, column));
  if (tile != nullptr) ILP_TRY(paint_tile(*tile, layer, work_.plan, scratch().canvas));
  if (++work_.painted < work_.tiles.count()) return {};
  finish_canvas(work_.plan, layer, scratch().canvas);
  return begin_search();
}

SunDirection MapFix::sun() const {
  const MissionParameters& mission = wiring_.mission;
  const MapDirectory& map = workspace_.directory;
  if (mission.map_sun_given) return {mission.map_sun_azimuth_rad, mission.map_sun_elevation_rad};
  if (map.body == Body::none) return {map.sun_azimuth_rad, map.sun_elevation_rad};
  constexpr double rad_per_deg = pi / 180;
  const SubsolarPoint point = subsolar_point(map.body, days_since_2000(mission.mission_epoch_s, work_.time_ns));
  const SunPlace place =
      sun_over(point, work_.record.longitude_deg * rad_per_deg, work_.record.latitude_deg * rad_per_deg);
  return {pi / 2 - place.azimuth_rad, place.elevation_rad};
}

Status MapFix::begin_search() {
  MapFixScratch& memory = scratch();
  const Vec3 centre = camera_centre(work_.prior.camera_from_map);
  const BodyPlace place = place_from_plane(workspace_.directory.body, part().origin(), {centre.x(), centre.y(), 0});
  work_.record.longitude_deg = place.longitude_deg;
  work_.record.latitude_deg = place.latitude_deg;
  MapRegistrationInput input;
  input.plan = work_.plan;
  input.window = window_of(work_.plan, workspace_.directory, memory.canvas);
  input.window.ground_m = work_.ground_m;
  input.prior = work_.prior;
  input.keyframes = {memory.together.data(), work_.together};
  input.sun = sun();
  if (work_.relief) {
    const auto scale = static_cast<float>(work_.scale);
    for (std::size_t i = 0; i < cell_count(memory.seen); ++i)
      memory.depth_m[i] = memory.inverse_depth[i] > 0 ? scale / memory.inverse_depth[i] : 0.0F;
    memory.depths.depth_m = {memory.depth_m.data(), memory.seen.columns, memory.seen.rows};
    memory.depths.first_px = 0.5 * (seen_cell_px - 1);
    memory.depths.step_px = seen_cell_px;
    input.depths = &memory.depths;
  }
  work_.phase = Phase::search;
  return memory.registration.begin(input, params_of(wiring_.mission, workspace_.directory), memory.work);
}

Status MapFix::search() {
  MapFixScratch& memory = scratch();
  ILP_TAKE(work_.keeps, memory.registration.step());
  if (work_.keeps) return {};
  const MapFixResult& result = memory.registration.result();
  const bool light_failed = !work_.relief && result.verdict != MapVerdict::fixed;
  if (light_failed && (wiring_.mission.map_senses & sense_relief) != 0 && work_.scale > 0) {
    // Without light: the keyframe's own relief.
    take_result(result);
    work_.relief = true;
    work_.keeps = true;
    work_.phase = Phase::plan;
    return {};
  }
  // Where relief says nothing either, the record tells of the light.
  if (!work_.relief || result.verdict == MapVerdict::fixed) take_result(result);
  if (result.verdict == MapVerdict::fixed) judge(result);
  conclude(work_.record.verdict);
  return {};
}

void MapFix::conclude(MapVerdict verdict) {
  work_.record.verdict = verdict;
  work_.keeps = false;
  work_.phase = Phase::record;
}

void MapFix::take_result(const MapFixResult& result) {
  FixRecord& record = work_.record;
  record.verdict = result.verdict;
  record.sense = result.sense;
  record.pixel_m = work_.plan.pixel_m;
  record.search_px = work_.plan.search_px;
  record.evidence = result.evidence;
  record.patches = static_cast<std::uint32_t>(std::max(result.patches, 0));
  record.votes = static_cast<std::uint32_t>(std::max(result.votes, 0));
  std::copy_n(result.shift_px, 2, record.shift_px);
  record.shift_sigmas = result.shift_sigmas;
  record.residual_px = result.residual_px;
  record.window_m[0] = work_.plan.x0_m();
  record.window_m[1] = work_.plan.y0_m();
  record.points.bytes = 0;
  work_.points.clear();
  if (result.verdict != MapVerdict::fixed) return;
  const MapDirectory& map = workspace_.directory;
  std::copy_n(result.ground_m, 3, record.ground_m);
  record.ground_covariance[0] = result.ground_covariance(0, 0);
  record.ground_covariance[1] = result.ground_covariance(1, 0);
  record.ground_covariance[2] = result.ground_covariance(1, 1);
  record.ground_height_sigma_m = std::max(map.height_sigma_m, 0.02 * work_.plan.pixel_m);
  quaternion_from_rotation(result.camera_from_map.rotation, record.q_cam_from_map);
  copy(camera_centre(result.camera_from_map), record.centre_m);
  for (int row = 0, k = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column) record.covariance[k++] = result.covariance(row, column);
  }
  const BodyPlace place = place_from_plane(map.body, part().origin(), {record.ground_m[0], record.ground_m[1], 0});
  record.longitude_deg = place.longitude_deg;
  record.latitude_deg = place.latitude_deg;
  for (const MapFixPoint& point : result.points) static_cast<void>(work_.points.push_back(point_of(point)));
  record.points.bytes = static_cast<std::uint32_t>(work_.points.size() * sizeof(FixPoint));
}

void MapFix::judge(const MapFixResult& result) {
  FixRecord& record = work_.record;
  // Only a fix that would count has numbers that the frame can use.
  record.state = FixState::accepted;
  navigation::MeasuredKeyframe& keyframe = workspace_.keyframe;
  keyframe.fix = fix_measurement(record, part().origin());
  record.state = FixState::none;
  if (!(keyframe.fix.ground_sigma_m[0] > 0)) return;
  MapState& after = workspace_.after;
  const bool wants_second =
      record.prior == FixPrior::search || after.lost != 0 || result.shift_sigmas > farthest_fix_sigmas;
  record.state = judge_fix(keyframe, work_.plan.pixel_m, wants_second, after.book, workspace_.near);
  if (record.state == FixState::accepted && after.lost != 0) {
    after.lost = 0;
    work_.updates = {StatusCode::place_found, record.id, static_cast<std::int64_t>(after.book.fixes.size())};
  }
}

/// Where the keyframe stands by the fixes that count, this one among them.
void MapFix::state_place() {
  const FixBook& book = workspace_.after.book;
  if (work_.pose.state != PoseState::final || book.fixes.empty() || workspace_.after.lost != 0) return;
  const navigation::StripFrame frame = frame_by_fixes(book, workspace_.near);
  const Vec3 way = vector_of(work_.pose.centre) - vector_of(book.fixes.back().centre);
  MapPrior place;
  if (!prior_by_fixes(frame, work_.pose, frame.metres_per_unit * way.norm(), place)) return;
  copy(camera_centre(place.camera_from_map), work_.record.place_m);
  work_.record.place_sigma_m = std::sqrt(std::max(place.covariance(3, 3), place.covariance(4, 4)));
  work_.record.newest_fix_id = book.fixes.back().keyframe_id;
}

Status MapFix::record() {
  FixRecord& record = work_.record;
  MapState& after = workspace_.after;
  const bool was_lost = state_.lost != 0;
  // What no second fix has confirmed leads nowhere else.
  if (after.book.fixes.empty() && record.prior == FixPrior::fixes && record.state == FixState::none)
    after.book.has_unconfirmed = 0;
  after.book.rejected += is_failure(record.verdict) && !after.book.fixes.empty() ? 1 : 0;
  if (!was_lost && after.book.rejected >= most_rejected) after.lost = 1;
  if (!was_lost && after.lost != 0 && !after.book.fixes.empty()) {
    work_.updates = {StatusCode::place_lost, record.id, static_cast<std::int64_t>(after.book.rejected)};
    after.book.fixes.clear();
    after.book.rejected = 0;
  }
  state_place();
  work_.patience.begin_writing();
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(wiring_.store, record));
  if (record.points.bytes != 0) {
    const std::span<const std::uint8_t> octets(reinterpret_cast<const std::uint8_t*>(work_.points.data()),
                                               record.points.bytes);
    ILP_TRY(write_blob<FixRecord>(wiring_.store, "points", record.id, 0, octets));
  }
  ILP_TRY(transaction.commit({record.id, cursor_.second}, after, cursor_, state_));
  work_.patience.end_writing();
  work_.phase = Phase::idle;
  const Status updates = work_.updates;
  work_.updates = {};
  return updates;
}

Status MapFix::advance() {
  switch (work_.phase) {
    case Phase::open:
      part().open();
      work_.phase = Phase::idle;
      return {};
    case Phase::idle:
      break;
    case Phase::load:
      return load();
    case Phase::survey:
      return survey();
    case Phase::start_image:
      return MapStart(wiring_, work_, workspace_).load_image();
    case Phase::start_features:
      return MapStart(wiring_, work_, workspace_).find_features();
    case Phase::start_compare:
      return MapStart(wiring_, work_, workspace_).compare();
    case Phase::plan:
      return plan();
    case Phase::paint:
      return paint();
    case Phase::search:
      return search();
    case Phase::record:
      return record();
  }
  return {};
}

StepResult MapFix::step() {
  if (!wiring_.mission.use_map) return {};
  // What was found so far is lost then.
  if (wiring_.mission.safe_mode && work_.phase != Phase::open) work_.phase = Phase::idle;
  work_.keeps = false;
  if (wiring_.mission.safe_mode) return {};
  const bool idle = work_.phase == Phase::idle;
  const Result<bool> picked = idle ? pick() : Result<bool>(true);
  const Status status = idle ? picked.status() : advance();
  work_.keeps = work_.keeps && status.ok();
  if (status.ok()) return {{}, picked.value(), work_.keeps ? Then::keep : Then::go_on};
  const bool reported = status.is(StatusCode::map_refused) || status.is(StatusCode::map_other_body) ||
                        status.is(StatusCode::map_tile_unusable) || status.is(StatusCode::place_lost) ||
                        status.is(StatusCode::place_found);
  if (reported) return {status, true};
  return work_.patience.failed(work_.depth.id, status);
}

}  // namespace ilp
