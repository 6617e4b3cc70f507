// The ground's model of a flight: the downlinked records and products, assigned to keyframes and strips.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "fsw/vision/geometry/similarity.hpp"
#include "fsw/vision/geometry/types.hpp"
#include "sim/ground/intake/outbox_reader.hpp"
#include "sim/ground/intake/product.hpp"
#include "sim/host/raster.hpp"

namespace ilp::intake {

/// A received product file.
struct ProductAccount {
  std::string file;               ///< name
  std::size_t bytes = 0;          ///< size with all refinements
  std::uint32_t grant_bytes = 0;  ///< bytes that the flight allowed for the product; 0: unknown
  ProductScheme scheme = ProductScheme::lossy_region;
  int layers = 0;
};

/// A point of the structure with the keyframes that see it.
struct StructureTrackPoint {
  StructurePoint point;
  std::vector<StructureObservation> observations;
};

/// The decoded products of a keyframe; a raster is empty if its product did not come down.
struct KeyframeRasters {
  host::Raster<std::uint8_t> image;
  host::Raster<std::uint8_t> mask;    ///< 255 where this keyframe's depth is new, else 0
  host::Raster<float> inverse_depth;  ///< 1 / strip unit, z forward; 0 outside the mask
  host::Raster<float>
      sigma_blocks;       ///< sigma of `inverse_depth` in blocks of sigma_block_px; empty: unknown; 0: no depth
  double depth_step = 0;  ///< quantisation step of `inverse_depth`
};

/// Everything known about one keyframe. Lengths are in the unit of its strip's world. Its rasters may stay undecoded
/// (keyframe_rasters.hpp), because decoded products take much memory.
struct Keyframe : KeyframeRasters {
  std::int64_t id = 0;
  std::int64_t strip_id = 0;
  std::string name;  ///< of the frame: a file name without folders, safe to print

  std::optional<KeyframeRecord> record;
  std::optional<OverlapRecord> overlap;
  std::optional<PoseRecord> pose;
  std::optional<StructureRecord> structure;
  std::optional<DepthRecord> depth;
  std::optional<MaskRecord> mask_record;
  std::optional<NavigationRecord> navigation;
  std::optional<FixRecord> fix;  ///< checked (valid_links.hpp); its ground_depth is in the unit of the strip's world
  std::optional<RichnessRecord> richness;
  std::array<std::optional<ProductRecord>, 2> product_records;  ///< index: ProductKind
  std::array<std::optional<ProductAccount>, 2> products;        ///< received and usable products; index: ProductKind

  std::vector<StructureTrackPoint> points;  ///< points that are decoded already; points_of() returns all
  CodedFile coded_points;                   ///< the other points: `structure->count`, checked
  std::vector<Similarity> points_moved;     ///< to be applied to the coded points, in this order
  CameraModel camera;
  std::array<CodedFile, 2> product_files;  ///< as received, with all refinements; index: ProductKind
  double depth_scale = 1;  ///< depth in the world's unit = depth_scale * depth as received (move_keyframe.hpp)
  std::int32_t mask_width = 0, mask_height = 0;
  CodedFile coded_mask;  ///< checked

  [[nodiscard]] bool has_image() const { return has(image, ProductKind::image); }
  [[nodiscard]] bool has_depth() const { return has(inverse_depth, ProductKind::depth); }
  [[nodiscard]] bool has_mask() const { return !mask.empty() || !coded_mask.empty(); }
  [[nodiscard]] const std::optional<ProductAccount>& product(ProductKind kind) const {
    return products[static_cast<std::size_t>(kind)];
  }
  [[nodiscard]] bool posed() const { return pose && pose->state == PoseState::final; }

 private:
  template <typename T>
  [[nodiscard]] bool has(const host::Raster<T>& raster, ProductKind kind) const {
    return !raster.empty() || !product_files[static_cast<std::size_t>(kind)].empty();
  }
};

/// Standard deviation of a pixel's inverse depth, with that of its quantisation; 0: unknown.
[[nodiscard]] double inverse_depth_sigma(const KeyframeRasters& keyframe, std::int32_t x, std::int32_t y);

/// How control points have placed a strip: its world is in metres and has the axes of the points.
struct ControlPlace {
  ilp::Body body = ilp::Body::none;            ///< none: the points' axes are local
  double longitude_deg = 0, latitude_deg = 0;  ///< of the world's origin; z is the height above the body's ellipsoid
  /// Standard deviations of scale (relative), vertical direction and vertical offset, from the points' residuals.
  double scale_sigma = 0, tilt_sigma_rad = 0, height_sigma_m = 0;
};

/// The orbiter's map that a strip is placed on. The strip's world has x to the east and y to the north in the map's
/// plane, and z is the elevation; all in m.
struct MapPlace {
  std::int64_t map_id = 0;
  ilp::Body body = ilp::Body::none;            ///< none: the map's axes are local
  double longitude_deg = 0, latitude_deg = 0;  ///< of the plane's origin
  double map_sigma_m = 0;                      ///< horizontal sigma per axis of the map's own position on the body
  /// Horizontal sigma per axis of the cameras' positions on the map, median; without map_sigma_m. 0: unknown.
  double place_sigma_m = 0;
};

struct Strip {
  std::int64_t id = 0;
  std::optional<StripRecord> record;
  std::optional<StripFrameRecord> frame;  ///< already applied (level_strips.hpp)
  std::optional<MapPlace> map;            ///< already applied, if fixes placed the strip; takes precedence over `frame`
  std::optional<ControlPlace> control;    ///< already applied; takes precedence over `map` and `frame`
  std::vector<std::int64_t> keyframes;    ///< ids, ascending
};

/// Housekeeping at one time of the flight. Each file of events has one report.
struct HousekeepingReport {
  StorageRecord storage;
  std::int64_t busy_ns = 0;  ///< processor time of all components since the process started
};

struct Flight {
  std::map<std::int64_t, Keyframe> keyframes;
  std::map<std::int64_t, Strip> strips;
  std::optional<CameraModel> camera;
  std::optional<CameraRecord> camera_record;                     ///< source of `camera`: frozen or only nominal
  std::map<std::int64_t, CalibrationRecord> calibrations;        ///< empty if the camera was known before the flight
  std::map<std::int64_t, CalibrationCheckRecord> camera_checks;  ///< key: strip id
  std::vector<EventRecord> events;                               ///< in the order of their ids
  std::vector<ComponentRecord> components;                       ///< in the order of their ids
  std::vector<LinkRecord> links;                                 ///< in the order of their ids
  std::map<std::int64_t, std::vector<LinkPoint>> link_points;    ///< key: link id
  std::vector<TieRecord> ties;                                   ///< in the order of their strips' ids
  std::optional<StorageRecord> storage;
  std::vector<HousekeepingReport> housekeeping;  ///< in the order of the flight
  std::optional<TimingRecord> timing;
  std::map<std::int64_t, OverlapRecord> overlaps;  ///< key: frame id; without the onboard database only keyframes
  std::map<std::int64_t, FrameRecord> frames;      ///< only from the onboard database
  std::map<std::int64_t, CaptureRecord> captures;  ///< only from the onboard database
  std::vector<std::string> remarks;                ///< for the report: contradictory, invalid or missing data
};

/// Assigns records and products to keyframes and strips, without decoding products. A product that contradicts its name
/// or its record gets a fault in `outbox`; the bytes of the other products move into the flight.
[[nodiscard]] Flight index_flight(Outbox& outbox);

/// Does the same as index_flight, and decodes all keyframes. A product that cannot be decoded gets a fault in `outbox`.
[[nodiscard]] Flight build_flight(Outbox& outbox);

/// Decodes the structure points that became final with the keyframe, in the current world of its strip.
[[nodiscard]] std::vector<StructureTrackPoint> points_of(const Keyframe& keyframe);

// Track and unit of a strip.

/// A camera centre in the strip's world.
struct TrackPoint {
  std::int64_t keyframe_id = 0;
  Vec3 centre = Vec3::Zero();
};
/// The camera centres of the strip's keyframes with final poses, in the order of their ids.
[[nodiscard]] std::vector<TrackPoint> track_of(const Flight& flight, const Strip& strip);

/// The unit of the strip's world: "units" if the scale is that of the first baseline, whose length is 1; else "m".
[[nodiscard]] const char* unit_of(const Flight& flight, const Strip& strip);

}  // namespace ilp::intake
