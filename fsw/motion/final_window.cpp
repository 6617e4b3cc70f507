#include "fsw/motion/final_window.hpp"

#include <algorithm>
#include <cstring>

#include "fsw/base/argument.hpp"
#include "fsw/motion/keyframe_motion.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

/// Reads the bytes of a structure in pieces.
class StructureReader {
 public:
  StructureReader(Reader<StructureRecord> store, const StructureRecord& structure)
      : store_(store), structure_(structure) {}

  [[nodiscard]] bool ended() const { return begin_ == end_ && offset_ == structure_.points.bytes; }

  template <typename T>
  Status read(T& out) {
    if (end_ - begin_ < sizeof(T)) ILP_TRY(fill());
    if (end_ - begin_ < sizeof(T)) {
      return {StatusCode::truncated, static_cast<std::int64_t>(offset_), structure_.points.bytes};
    }
    std::memcpy(&out, segment_ + begin_, sizeof(T));
    begin_ += sizeof(T);
    return {};
  }

 private:
  Status fill() {
    std::memmove(segment_, segment_ + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
    const std::size_t size = std::min(sizeof(segment_) - end_, structure_.points.bytes - offset_);
    if (size == 0) return {};
    ILP_TRY(read_blob<StructureRecord>(store_, "points", structure_.id, offset_, {segment_ + end_, size}));
    end_ += size;
    offset_ += size;
    return {};
  }

  Reader<StructureRecord> store_;
  const StructureRecord& structure_;
  std::size_t offset_ = 0;
  std::size_t begin_ = 0, end_ = 0;
  std::uint8_t segment_[4096];
};

Status add_point(StructureReader& reader, const CameraModel& camera, std::span<const std::int64_t> keyframe_ids,
                 BundleProblem& window) {
  StructurePoint head;
  ILP_TRY(reader.read(head));
  const std::size_t before = window.observations.size();
  for (std::uint32_t i = 0; i < head.observations; ++i) {
    StructureObservation seen;
    ILP_TRY(reader.read(seen));
    const auto at = std::find(keyframe_ids.begin(), keyframe_ids.end(), seen.keyframe_id);
    const auto view = static_cast<std::size_t>(at - keyframe_ids.begin());
    if (view == keyframe_ids.size()) continue;
    const Vec2 ideal = ideal_from_pixel(camera, Vec2(static_cast<double>(seen.x), static_cast<double>(seen.y)));
    const BundleObservation observation{static_cast<std::uint16_t>(view),
                                        static_cast<std::uint16_t>(window.points.size()), ideal.x(), ideal.y()};
    static_cast<void>(window.observations.push_back(observation));
  }
  BundlePoint point;
  std::copy_n(head.position, 3, point.position);
  if (window.observations.size() - before < 2 || !window.points.push_back(point)) {
    static_cast<void>(window.observations.resize(before));
  }
  return {};
}

}  // namespace

Status load_final_window(Reader<PoseRecord, StructureRecord> store, const CameraModel& camera,
                         std::span<const std::int64_t> keyframe_ids, std::int64_t through_id, BundleProblem& window) {
  window.cameras.clear();
  window.points.clear();
  window.observations.clear();
  window.attitudes.clear();
  window.hold = {};
  if (keyframe_ids.empty()) return {};
  for (const std::int64_t id : keyframe_ids) {
    PoseRecord pose;
    ILP_TRY(get(store, id, pose));
    const BundleCamera bundle_camera{pose_of(pose), camera.fx, camera.fy, camera.cx, camera.cy, false};
    if (!window.cameras.push_back(bundle_camera)) return out_of_range(Argument::window, window.cameras.size());
  }
  StructureRecord structure;
  std::int64_t id = keyframe_ids.front() - 1;
  // bound: the keyframes up to `through_id`
  for (Status found = next(store, id, structure);; found = next(store, id, structure)) {
    if (found.is(StatusCode::not_found) || (found.ok() && structure.id > through_id)) return {};
    ILP_TRY(found);
    id = structure.id;
    StructureReader reader(store, structure);
    // bound: the points of the record
    while (!reader.ended()) ILP_TRY(add_point(reader, camera, keyframe_ids, window));
  }
}

Status load_motion(Reader<ShutterRecord> store, const CameraModel& camera, bool readout_open,
                   std::span<const std::int64_t> keyframe_ids, WindowMotion& motion) {
  motion = {};
  motion.readout_s = camera.readout_s;
  motion.readout_open = readout_open;
  for (std::size_t i = 0; i < keyframe_ids.size(); ++i) {
    ShutterRecord shutter;
    ILP_TAKE(const bool recorded, find<ShutterRecord>(store, keyframe_ids[i], shutter));
    if (!recorded) shutter = {};
    std::copy_n(shutter.motion, 8, motion.of_view[i].m);
    motion.sigma_px_s[i] = motion_sigma_px_s(camera, shutter);
  }
  return {};
}

}  // namespace ilp
