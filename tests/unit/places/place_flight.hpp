// What the stages before the memory of places write about a flight over analytic ground.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <stdexcept>
#include <vector>

#include "fsw/vision/geometry/similarity.hpp"
#include "fsw/vision/terrain/mask_coding.hpp"
#include "fsw/vision/terrain/seen_cells.hpp"
#include "hal/store/store.hpp"
#include "tests/unit/vision/stereo/analytic_scene.hpp"

namespace ilp::test {

class PlaceFlight {
 public:
  static constexpr double height = 100;
  static constexpr double step = 20;           // of an image that shows 105 of the ground
  static constexpr double second_unit = 0.25;  // metres are units of the first strip; the second one's are four metres

  static double gentle(double x, double y) { return 3 * std::sin(x / 17) * std::cos(y / 13); }

  /// The store outlives the flight.
  explicit PlaceFlight(Store& store, const CameraModel& camera = distorting_camera())
      : camera_(camera), store_(store) {}

  void write_camera() const { record(camera_record(camera_)); }

  /// Rendered once in a process.
  [[nodiscard]] const View& view_of(const RigidTransform& cam_from_ground, std::uint64_t noise_seed) const {
    using Key = std::array<double, 13>;
    static std::map<Key, View> views;
    Key key{};
    std::copy_n(cam_from_ground.rotation.data(), 9, key.begin());
    std::copy_n(cam_from_ground.translation.data(), 3, key.begin() + 9);
    key[12] = static_cast<double>(noise_seed);
    const auto known = views.find(key);
    if (known != views.end()) return known->second;
    return views[key] = render_view(camera_, cam_from_ground, gentle, 2, 1, noise_seed);
  }

  /// A keyframe with depth everywhere and all of its image new. Its strip's world is turned, moved and in another unit.
  void see(std::int64_t id, std::int64_t strip, std::int32_t index, const RigidTransform& cam_from_ground,
           const Similarity& strip_from_ground, std::uint64_t noise_seed) {
    show(id, strip, index, view_of(cam_from_ground, noise_seed), cam_from_ground, strip_from_ground);
  }
  /// The same with any view, and with the pose that is on record for it.
  void show(std::int64_t id, std::int64_t strip, std::int32_t index, const View& view,
            const RigidTransform& cam_from_ground, const Similarity& strip_from_ground) {
    KeyframeRecord keyframe{.id = id, .frame_id = id, .strip_id = strip, .index = index};
    if (index > 0) keyframe.overlap = overlap_;
    record(keyframe);
    FrameRecord frame{.id = id, .width = view.image.width, .height = view.image.height};
    frame.image.bytes = static_cast<std::uint32_t>(view.image.pixels.size());
    record(frame, {{"image", view.image.pixels}});
    const Similarity cam_from_strip = compose(Similarity{Mat3::Identity(), Vec3::Zero(), strip_from_ground.scale},
                                              compose(similarity_from(cam_from_ground), inverse(strip_from_ground)));
    RigidTransform rigid{cam_from_strip.rotation, cam_from_strip.translation};
    const Pose pose = pose_from(rigid);
    PoseRecord posed{.id = id, .strip_id = strip, .state = PoseState::final};
    std::copy_n(pose.q_cam_from_world, 4, posed.q_cam_from_world);
    std::copy_n(pose.centre, 3, posed.centre);
    record(posed);
    write_depth(id, strip, view, strip_from_ground.scale);
  }

  void write_depth(std::int64_t id, std::int64_t strip, const View& view, double unit) {
    const std::size_t area = view.depth.size();
    std::vector<float> inverse(area);
    for (std::size_t i = 0; i < area; ++i) inverse[i] = static_cast<float>(1 / (unit * view.depth[i]));
    std::vector<float> sigma(area);
    for (std::size_t i = 0; i < area; ++i) sigma[i] = 0.002F * inverse[i];
    const ImageView<const float> inverse_view(inverse.data(), camera_.width, camera_.height);
    const ImageView<const float> sigma_view(sigma.data(), camera_.width, camera_.height);
    const auto cells = std::make_unique<SeenCells>();
    const auto depths = std::make_unique<CellDepths>();
    check(seen_cells(inverse_view, sigma_view, camera_.fx, 16, *cells));
    check(cell_depths(inverse_view, sigma_view, 16, *depths));
    const std::size_t count = static_cast<std::size_t>(cells->columns) * static_cast<std::size_t>(cells->rows);
    std::vector<std::uint8_t> bytes(cells->quality.begin(),
                                    cells->quality.begin() + static_cast<std::ptrdiff_t>(count));
    const auto* depth_bytes = reinterpret_cast<const std::uint8_t*>(depths->data());
    bytes.insert(bytes.end(), depth_bytes, depth_bytes + count * sizeof(float));
    std::vector<std::uint8_t> mask(area, 255);
    std::vector<std::uint8_t> coded(max_mask_bytes(area));
    std::size_t coded_bytes = 0;
    check(encode_mask({mask.data(), camera_.width, camera_.height}, coded.data(), coded.size(), coded_bytes));
    coded.resize(coded_bytes);
    DepthRecord depth{.id = id, .strip_id = strip, .width = camera_.width, .height = camera_.height};
    depth.cells.bytes = static_cast<std::uint32_t>(bytes.size());
    record(depth, {{"cells", bytes}});
    MaskRecord new_ground;
    new_ground.id = id;
    new_ground.width = camera_.width;
    new_ground.height = camera_.height;
    new_ground.newly_seen = static_cast<std::uint32_t>(area);
    new_ground.code.bytes = static_cast<std::uint32_t>(coded.size());
    record(new_ground, {{"code", coded}});
  }

  /// Keyframes 1 to 6 fly along x; 7 to 10 fly back over them, turned by 2 rad, as a strip with its own world.
  void fly_out() {
    for (std::int64_t id = 1; id <= 6; ++id) {
      see(id, 1, static_cast<std::int32_t>(id - 1), looking_down(Vec3(step * static_cast<double>(id), 0, height)),
          Similarity{}, static_cast<std::uint64_t>(id));
    }
  }
  void fly_back() {
    for (std::int64_t id = 7; id <= 10; ++id) {
      see(id, 2, static_cast<std::int32_t>(id - 7),
          looking_down(Vec3(step * static_cast<double>(13 - id), 5, 1.1 * height), Vec3(0, 0, 2)), second_,
          static_cast<std::uint64_t>(id));
    }
  }

  CameraModel camera_;
  double overlap_ = 0.8;  ///< as stated, of keyframes that follow each other
  /// From the first strip's world, which is the ground's.
  Similarity second_{rotation_from_vector(Vec3(0.1, -0.2, 0.7)), Vec3(3, 1, -2), second_unit};

 private:
  struct Blob {
    const char* field;
    const std::vector<std::uint8_t>& bytes;
  };
  static void check(const Status& status) {
    if (!status.ok()) throw std::runtime_error(status_name(status.code));
  }
  template <typename Record>
  void record(const Record& record, std::initializer_list<Blob> blobs = {}) const {
    Transaction transaction(store_);
    check(transaction.begin());
    check(put(store_, record));
    for (const Blob& blob : blobs) check(write_blob<Record>(store_, blob.field, record.id, 0, blob.bytes));
    check(transaction.commit());
  }

  Store& store_;
};

}  // namespace ilp::test
