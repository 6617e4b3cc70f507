// How the coordinates of the flight's map and those of the other terrain model belong together.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/compare/height_model.hpp"
#include "sim/host/alignment.hpp"

namespace ilp::compare {

/// How the map's axes reach those of the other model.
struct FrameOptions {
  /// Poses of the same images in the coordinates of the other model (host/reference_cameras.hpp), for a map in the axes
  /// of its strip; may be empty.
  std::filesystem::path poses;
  bool same_axes = false;  ///< the coordinates are the same, whatever the files state
};

/// The way of a point of the map to the other model. Points are compared in the *common frame*: the map's coordinate
/// system or, with poses, the axes of the other model.
class ModelFrames {
 public:
  /// std::runtime_error says why there is no way: no coordinate system, two bodies, a map without a place.
  ModelFrames(const HeightModel& map, const HeightModel& other, const FrameOptions& options);
  ~ModelFrames();
  ModelFrames(const ModelFrames&) = delete;
  ModelFrames& operator=(const ModelFrames&) = delete;

  /// From the map's coordinates into the common frame.
  [[nodiscard]] const host::Similarity3& common_from_map() const { return common_from_map_; }
  /// Of the common frame, as WKT; empty where nobody states it.
  [[nodiscard]] const std::string& system() const { return system_; }
  /// What the reader should know, such as the figure to which heights refer.
  [[nodiscard]] const std::vector<std::string>& remarks() const { return remarks_; }

  /// x, y of the common frame become column and row of the other model (the centre of its first pixel is (0, 0)); NaN
  /// where there is no way.
  void to_pixels(std::vector<double>& x, std::vector<double>& y) const;

 private:
  void join_systems(const HeightModel& map, const HeightModel& other);
  void join_by_poses(const HeightModel& map, const HeightModel& other, const std::filesystem::path& poses);

  host::Similarity3 common_from_map_;
  std::string system_;
  std::vector<std::string> remarks_;
  void* transformation_ = nullptr;  ///< of OGR; null where the systems are the same
  GeoTransform pixel_from_other_{};
  double middle_px_ = 0;  ///< column in the middle of the other model
  double turn_px_ = 0;    ///< columns of 360 degrees in a model in degrees, else 0
};

}  // namespace ilp::compare
