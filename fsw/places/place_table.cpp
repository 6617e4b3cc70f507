#include "fsw/places/place_table.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

constexpr double linked_share = 0.5;
constexpr double largest_scale = 2;

Vec3 centre_of(const RememberedPlace& place) {
  return {static_cast<double>(place.centre[0]), static_cast<double>(place.centre[1]),
          static_cast<double>(place.centre[2])};
}

/// Distance of a point from the middle of the image in half its shorter side; a large one behind the camera.
double off_centre(const Vec3& x, const CameraModel& camera) {
  if (!(x.z() > 0)) return 1e9;
  const double half = 0.5 * std::min(camera.width, camera.height);
  const double u = camera.fx * x.x() / x.z();
  const double v = camera.fy * x.y() / x.z();
  return std::sqrt(u * u + v * v) / half;
}

}  // namespace

RigidTransform camera_at(const RememberedPlace& place) {
  Pose pose;
  for (int i = 0; i < 4; ++i) pose.q_cam_from_world[i] = static_cast<double>(place.q_cam_from_world[i]);
  for (int i = 0; i < 3; ++i) pose.centre[i] = static_cast<double>(place.centre[i]);
  return cam_from_world(pose);
}

Vec3 ground_of(const RememberedPlace& place) {
  return inverse(camera_at(place)) * Vec3(0, 0, static_cast<double>(place.ground_distance));
}

const RememberedPlace* PlaceTable::newest() const {
  return known(newest_) ? &places_[newest_ - 1U] : nullptr;
}

std::array<std::size_t, 2> PlaceTable::newest_slots() const {
  std::array<std::size_t, 2> slots{limits::max_places, limits::max_places};
  if (!known(newest_)) return slots;
  slots[0] = newest_ - std::size_t{1};
  if (known(places_[slots[0]].before)) slots[1] = places_[slots[0]].before - std::size_t{1};
  return slots;
}

void PlaceTable::clear() {
  places_.fill({});
  count_ = 0;
  newest_ = 0;
}

bool PlaceTable::add(std::size_t slot, const RememberedPlace& place) {
  if (slot >= places_.size() || places_[slot].keyframe_id != 0 || place.keyframe_id <= 0) return false;
  if (const RememberedPlace* last = newest(); last != nullptr && last->keyframe_id >= place.keyframe_id) return false;
  places_[slot] = place;
  places_[slot].before = newest_;
  places_[slot].after = 0;
  const auto number = static_cast<std::uint16_t>(slot + 1);
  if (known(newest_)) places_[newest_ - 1U].after = number;
  newest_ = number;
  ++count_;
  return true;
}

void PlaceTable::remove(std::size_t slot) {
  if (slot >= places_.size() || places_[slot].keyframe_id == 0) return;
  const RememberedPlace gone = places_[slot];
  if (known(gone.before)) places_[gone.before - 1U].after = gone.after;
  if (known(gone.after)) places_[gone.after - 1U].before = gone.before;
  if (newest_ == slot + 1) newest_ = gone.before;
  places_[slot] = {};
  --count_;
}

double PlaceTable::need(const RememberedPlace& place) const {
  if (!(place.ground_distance > 0)) return 0;
  const double distance = static_cast<double>(place.ground_distance);
  const auto beside = [&](std::uint16_t number) -> const RememberedPlace* {
    if (!known(number)) return nullptr;
    const RememberedPlace& other = places_[number - 1U];
    return other.strip_id == place.strip_id && other.ground_distance > 0 ? &other : nullptr;
  };
  const RememberedPlace* before = beside(place.before);
  const RememberedPlace* after = beside(place.after);
  double gap = 1;
  if (before != nullptr && after != nullptr) gap = (centre_of(*after) - centre_of(*before)).norm() / distance;
  return place.seen_again ? linked_share * gap : gap;
}

std::size_t PlaceTable::least_needed() const {
  std::size_t least = places_.size();
  double least_need = 0;
  for (std::size_t slot = kept_for_ever; slot < places_.size(); ++slot) {
    if (places_[slot].keyframe_id == 0 || newest_ == slot + 1) continue;
    const double needed = need(places_[slot]);
    if (least < places_.size() && !(needed < least_need)) continue;
    least = slot;
    least_need = needed;
  }
  return least;
}

void PlaceTable::find_near(std::int64_t strip_id, std::int64_t through_id, const Similarity& cam_from_world,
                           double ground_distance, double farthest, const CameraModel& camera, NearPlaces& near) const {
  near.clear();
  if (!(ground_distance > 0)) return;
  const Similarity world_from_cam = inverse(cam_from_world);
  const Vec3 ground = world_from_cam * Vec3(0, 0, ground_distance);
  const double distance_in_world = ground_distance * world_from_cam.scale;
  for (std::size_t slot = 0; slot < places_.size(); ++slot) {
    const RememberedPlace& place = places_[slot];
    if (place.keyframe_id == 0 || place.strip_id != strip_id || place.keyframe_id > through_id) continue;
    if (!(place.ground_distance > 0)) continue;
    const double ratio = static_cast<double>(place.ground_distance) / distance_in_world;
    if (!(ratio < largest_scale && ratio * largest_scale > 1)) continue;
    const RigidTransform pose = camera_at(place);
    const double here = off_centre(pose * ground, camera);
    const double there = off_centre(cam_from_world * ground_of(place), camera);
    const double distance = std::min(here, there);
    if (!(distance < farthest)) continue;
    std::size_t at = near.size();
    while (at > 0 && distance < near[at - 1].distance) --at;
    if (at == near.capacity()) continue;
    if (near.size() == near.capacity()) static_cast<void>(near.resize(near.size() - 1));
    static_cast<void>(near.push_back({}));
    for (std::size_t k = near.size() - 1; k > at; --k) near[k] = near[k - 1];
    near[at] = {static_cast<std::uint16_t>(slot), distance};
  }
}

}  // namespace ilp
