// Compares poses and depths with the truth or with a reference reconstruction.
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

/// Reference poses by image name, and the true depth (z, reference units) of an image where there is one.
class Reference {
 public:
  virtual ~Reference() = default;
  [[nodiscard]] virtual const ReferencePose* pose(const std::string& name) const = 0;
  /// Empty when unknown; values that are not positive and finite are no depth.
  [[nodiscard]] virtual host::Raster<float> depth(const std::string& name) const = 0;
};

/// The posed keyframes of a strip that have a reference, in order.
struct PosePairs {
  std::vector<std::int64_t> keyframes;
  host::CameraTrack track, reference;
};
[[nodiscard]] PosePairs pose_pairs(const intake::Flight& flight, const intake::Strip& strip,
                                   const Reference& reference);

/// The alignment of a strip has 7 degrees of freedom: with fewer positions its residuals say nothing, and no figure of
/// the flight counts them.
inline constexpr std::size_t fewest_poses = 4;

/// What to tell a user whose reference is not of this flight, or is damaged; empty where it may well be of it. Names of
/// images repeat from flight to flight, and an alignment hides much. `rotation_deg`: mean difference of attitudes after
/// the alignment. `position_percent`: mean difference of positions, of the distance flown.
[[nodiscard]] std::string foreign_reference(std::size_t poses, double rotation_deg, double position_percent);

struct DepthAccuracy {
  std::size_t pixels = 0;
  double flying_height = 0;       ///< median true depth of the image
  double median_abs = 0;          ///< of aligned minus true depth, reference units
  double median_abs_percent = 0;  ///< of the flying height, scale from the positions (see StripAccuracy)
  double own_scale_percent = 0;   ///< the same with this keyframe's own best scale: shape alone
  double bias_percent = 0;        ///< median of aligned minus true
};

struct KeyframeAccuracy {
  double position = 0;      ///< reference units
  double rotation_rad = 0;  ///< after the attitudes were aligned
  std::optional<DepthAccuracy> depth;
};

/// Errors of the places of cameras on a map, m, without any alignment.
struct MapAccuracy {
  host::ErrorSummary position, horizontal;
  double nes = unknown;  ///< mean square of the errors in stated ones, for each coordinate: 1 where they are as stated
};

struct StripAccuracy {
  host::Similarity3 reference_from_strip;
  std::size_t poses = 0;
  double length = 0;  ///< path length of the reference centres, in order of keyframes
  double extent = 0;  ///< largest distance of two reference centres
  host::ErrorSummary position;
  /// Position errors when the alignment's rotation comes from the attitudes instead of the positions.
  host::ErrorSummary position_with_attitude;
  host::ErrorSummary rotation_rad;
  std::optional<MapAccuracy> on_map;
  std::optional<host::ErrorSummary> depth_percent;  ///< of the keyframes' median_abs_percent
  std::map<std::int64_t, KeyframeAccuracy> keyframes;

  [[nodiscard]] double percent_of_length(double error) const { return length > 0 ? 100 * error / length : unknown; }
  [[nodiscard]] double percent_of_extent(double error) const { return extent > 0 ? 100 * error / extent : unknown; }
};

/// None when fewer than two posed keyframes have a reference.
[[nodiscard]] std::optional<StripAccuracy> measure_accuracy(const intake::Flight& flight, const intake::Strip& strip,
                                                            const Reference& reference);

/// Of a strip that stands on a map, by a reference in the coordinates of the map's plane, as a simulated world has
/// them. None for other strips.
[[nodiscard]] std::optional<MapAccuracy> measure_on_map(const intake::Flight& flight, const intake::Strip& strip,
                                                        const Reference& reference);

// Reference poses from camera text files, true depths from PFM files.

/// Poses as sim/host/reference_cameras.hpp reads them. Names match with or without their extension. Depths are
/// FOLDER/NAME.pfm.
class ReferenceFiles final : public Reference {
 public:
  /// `depth_folder` may be empty. Throws std::runtime_error as read_reference_cameras, and for names that differ only
  /// in their extension.
  ReferenceFiles(const std::filesystem::path& poses, std::filesystem::path depth_folder);
  [[nodiscard]] const ReferencePose* pose(const std::string& name) const override;
  [[nodiscard]] host::Raster<float> depth(const std::string& name) const override;

 private:
  std::map<std::string, ReferencePose> poses_;  ///< by name without extension
  std::filesystem::path depth_folder_;
};

}  // namespace ilp::report
