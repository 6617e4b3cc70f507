// Relates the coordinates of the flight's map to those of the other terrain model.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/compare/height_model.hpp"
#include "sim/host/alignment.hpp"

namespace ilp::compare {

/// How the coordinates are related if not by the files' coordinate systems.
struct FrameOptions {
  /// Poses of the same images in the coordinates of the other model (host/reference_cameras.hpp), for a map in the axes
  /// of its strip; may be empty.
  std::filesystem::path poses;
  bool same_axes = false;  ///< both have the same coordinates, regardless of what the files state
};

/// Transforms points of the map to the other model. Points are compared in the *common frame*: the map's coordinate
/// system or, with poses, the axes of the other model.
class ModelFrames {
 public:
  /// Throws std::runtime_error that says why there is no transformation: no coordinate system, two bodies, or a map
  /// without a position.
  ModelFrames(const HeightModel& map, const HeightModel& other, const FrameOptions& options);
  ~ModelFrames();
  ModelFrames(const ModelFrames&) = delete;
  ModelFrames& operator=(const ModelFrames&) = delete;

  /// Transformation from the map's coordinates to the common frame.
  [[nodiscard]] const host::Similarity3& common_from_map() const { return common_from_map_; }
  /// Coordinate system of the common frame as WKT; empty: unknown.
  [[nodiscard]] const std::string& system() const { return system_; }
  /// Remarks for the user, such as the ellipsoid to which heights refer.
  [[nodiscard]] const std::vector<std::string>& remarks() const { return remarks_; }

  /// Replaces x and y in the common frame by column and row of the other model, with the centre of the first pixel at
  /// (0, 0); NaN if a point cannot be transformed.
  void to_pixels(std::vector<double>& x, std::vector<double>& y) const;

 private:
  void join_systems(const HeightModel& map, const HeightModel& other);
  void join_by_poses(const HeightModel& map, const HeightModel& other, const std::filesystem::path& poses);

  host::Similarity3 common_from_map_;
  std::string system_;
  std::vector<std::string> remarks_;
  void* transformation_ = nullptr;  ///< OGRCoordinateTransformation; null if the systems are the same
  GeoTransform pixel_from_other_{};
  double middle_px_ = 0;  ///< column in the middle of the other model
  double turn_px_ = 0;    ///< number of columns in 360 degrees if the other model is in degrees; else 0
};

}  // namespace ilp::compare
