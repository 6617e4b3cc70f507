// Compares the poses and depths of a flight with the truth or with a reference reconstruction.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/host/alignment.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::report {

struct ReferencePose {
  Mat3 cam_from_world = Mat3::Identity();
  Vec3 centre = Vec3::Zero();
};

/// A source of reference poses and true depths. Key: image name.
class Reference {
 public:
  virtual ~Reference() = default;
  /// Pose of an image; null: unknown.
  [[nodiscard]] virtual const ReferencePose* pose(const std::string& name) const = 0;
  /// Depth map of an image (camera z, reference units); empty: unknown. Values that are not positive and finite mean no
  /// depth.
  [[nodiscard]] virtual host::Raster<float> depth(const std::string& name) const = 0;
};

/// The keyframes of a strip with a final pose and a reference pose, in the order of the strip.
struct PosePairs {
  std::vector<std::int64_t> keyframes;
  host::CameraTrack track, reference;
};
[[nodiscard]] PosePairs pose_pairs(const intake::Flight& flight, const intake::Strip& strip,
                                   const Reference& reference);

/// Fewest poses of a strip for a measure of accuracy. The alignment has 7 degrees of freedom, so that the residuals of
/// fewer positions mean nothing; no total of the flight contains them.
inline constexpr std::size_t fewest_poses = 4;

/// A warning that the reference seems to be of another flight, or damaged; empty if it is plausible. Image names repeat
/// from flight to flight, and the alignment hides many differences. `rotation_deg`: mean difference of attitudes after
/// the alignment. `position_percent`: mean difference of positions, in % of the distance flown.
[[nodiscard]] std::string foreign_reference(std::size_t poses, double rotation_deg, double position_percent);

/// Depth errors of a keyframe: aligned minus true depth. The scale of the alignment is that of the strip's positions
/// (StripAccuracy). Percentages are of the flying height.
struct DepthAccuracy {
  std::size_t pixels = 0;         ///< number of compared pixels
  double flying_height = 0;       ///< median true depth of the image, reference units
  double median_abs = 0;          ///< median absolute error, reference units
  double median_abs_percent = 0;  ///< median absolute error, %
  double own_scale_percent = 0;   ///< the same with the keyframe's own best scale: error of the shape alone
  double bias_percent = 0;        ///< median error, %
};

struct KeyframeAccuracy {
  double position = 0;      ///< position error, reference units
  double rotation_rad = 0;  ///< attitude error after the alignment of the attitudes
  std::optional<DepthAccuracy> depth;
};

/// Position errors of the cameras on a map, m, without alignment.
struct MapAccuracy {
  host::ErrorSummary position, horizontal;
  double nes = unknown;  ///< mean normalised error squared (by the poses' covariances) per coordinate; 1: as estimated
};

struct StripAccuracy {
  host::Similarity3 reference_from_strip;
  std::size_t poses = 0;
  double length = 0;  ///< path length of the reference centres, in the order of the keyframes
  double extent = 0;  ///< largest distance between two reference centres
  host::ErrorSummary position;
  /// Position errors if the alignment's rotation is from the attitudes instead of the positions.
  host::ErrorSummary position_with_attitude;
  host::ErrorSummary rotation_rad;
  std::optional<MapAccuracy> on_map;
  std::optional<host::ErrorSummary> depth_percent;     ///< over the keyframes' median_abs_percent
  std::map<std::int64_t, KeyframeAccuracy> keyframes;  ///< key: keyframe id

  [[nodiscard]] double percent_of_length(double error) const { return length > 0 ? 100 * error / length : unknown; }
  [[nodiscard]] double percent_of_extent(double error) const { return extent > 0 ? 100 * error / extent : unknown; }
};

/// Aligns a strip to the reference and measures its errors. None if the alignment is impossible, as with fewer than two
/// posed keyframes that have a reference.
[[nodiscard]] std::optional<StripAccuracy> measure_accuracy(const intake::Flight& flight, const intake::Strip& strip,
                                                            const Reference& reference);

/// Measures a strip that is placed on a map. The reference must be in the coordinates of the map's plane, as a
/// simulated world has them. None for other strips.
[[nodiscard]] std::optional<MapAccuracy> measure_on_map(const intake::Flight& flight, const intake::Strip& strip,
                                                        const Reference& reference);

/// Reference poses from a camera text file (sim/host/reference_cameras.hpp), and true depths from the files
/// FOLDER/NAME.pfm. Image names match with or without their extension.
class ReferenceFiles final : public Reference {
 public:
  /// `depth_folder`: empty: no depths. Throws as read_reference_cameras does, and throws std::runtime_error for names
  /// that differ only in their extension.
  ReferenceFiles(const std::filesystem::path& poses, std::filesystem::path depth_folder);
  [[nodiscard]] const ReferencePose* pose(const std::string& name) const override;
  [[nodiscard]] host::Raster<float> depth(const std::string& name) const override;

 private:
  std::map<std::string, ReferencePose> poses_;  ///< key: name without extension
  std::filesystem::path depth_folder_;
};

}  // namespace ilp::report
