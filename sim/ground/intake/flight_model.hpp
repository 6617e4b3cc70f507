// A flight as the ground holds it: all that came down, decoded and put in order.
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

struct ProductAccount {
  std::string file;
  std::size_t bytes = 0;
  std::uint32_t grant_bytes = 0;  ///< 0 when unknown
  ProductScheme scheme = ProductScheme::lossy_region;
  int layers = 0;
};

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
      sigma_blocks;       ///< one sigma of `inverse_depth` by blocks of sigma_block_px; empty: unknown, 0: none
  double depth_step = 0;  ///< of `inverse_depth` as sent
};

/// Everything known about one keyframe. Lengths are in the unit of its strip's world. Its rasters may be left undecoded
/// (keyframe_rasters.hpp), because coded products take little memory and decoded ones much.
struct Keyframe : KeyframeRasters {
  std::int64_t id = 0;
  std::int64_t strip_id = 0;
  std::string name;  ///< of its frame: a plain file name, safe to print

  std::optional<KeyframeRecord> record;
  std::optional<OverlapRecord> overlap;
  std::optional<PoseRecord> pose;
  std::optional<StructureRecord> structure;
  std::optional<DepthRecord> depth;
  std::optional<MaskRecord> mask_record;
  std::optional<NavigationRecord> navigation;
  std::optional<FixRecord> fix;  ///< valid; its ground_depth is in the unit of the strip's world
  std::optional<RichnessRecord> richness;
  std::array<std::optional<ProductRecord>, 2> product_records;  ///< by ProductKind
  std::array<std::optional<ProductAccount>, 2> products;        ///< received and decoded, by ProductKind

  std::vector<StructureTrackPoint> points;  ///< decoded; the others are in `coded_points` (points_of)
  CodedFile coded_points;                   ///< valid; of `structure->count` points
  std::vector<Similarity> points_moved;     ///< since they were coded, one after the other
  CameraModel camera;
  std::array<CodedFile, 2> product_files;  ///< as received with all refinements, by ProductKind
  double depth_scale = 1;  ///< units of its world now for a unit of the depths as sent (move_keyframe.hpp)
  std::int32_t mask_width = 0, mask_height = 0;
  CodedFile coded_mask;  ///< valid

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

/// One sigma of the inverse depth of a pixel, with that of its rounding to steps; 0 where it is unknown.
[[nodiscard]] double inverse_depth_sigma(const KeyframeRasters& keyframe, std::int32_t x, std::int32_t y);

/// Where control points have put a strip: its world is in metres, with the axes of the points.
struct ControlPlace {
  ilp::Body body = ilp::Body::none;            ///< none: the points have axes of their own
  double longitude_deg = 0, latitude_deg = 0;  ///< of the world's origin, whose z is the height above the body's figure
  /// One sigma each, by the residuals of the points: relative, of what is up, of the height as a whole.
  double scale_sigma = 0, tilt_sigma_rad = 0, height_sigma_m = 0;
};

/// The map of an orbiter on whose plane a strip stands: x to the east, y to the north, z is the elevation, m.
struct MapPlace {
  std::int64_t map_id = 0;
  ilp::Body body = ilp::Body::none;            ///< none: the map has axes of its own
  double longitude_deg = 0, latitude_deg = 0;  ///< of the plane's origin
  double map_sigma_m = 0;                      ///< of the place of the whole map on the body, to each side
  /// Of the cameras on the map, to each side, median; the error of the map's own place comes to it. 0: not known.
  double place_sigma_m = 0;
};

struct Strip {
  std::int64_t id = 0;
  std::optional<StripRecord> record;
  std::optional<StripFrameRecord> frame;  ///< already applied (level_strips.hpp)
  std::optional<MapPlace> map;            ///< it stands on this map by its fixes; precedes `frame`
  std::optional<ControlPlace> control;    ///< already applied; precedes `map` and `frame`
  std::vector<std::int64_t> keyframes;    ///< by id
};

/// Housekeeping at one time of the flight: each file of events brings it.
struct HousekeepingReport {
  StorageRecord storage;
  std::int64_t busy_ns = 0;  ///< processor time of all components since the process began
};

struct Flight {
  std::map<std::int64_t, Keyframe> keyframes;
  std::map<std::int64_t, Strip> strips;
  std::optional<CameraModel> camera;
  std::optional<CameraRecord> camera_record;                     ///< what `camera` comes from: frozen or only nominal
  std::map<std::int64_t, CalibrationRecord> calibrations;        ///< only where the camera was not known
  std::map<std::int64_t, CalibrationCheckRecord> camera_checks;  ///< by strip
  std::vector<EventRecord> events;                               ///< by id
  std::vector<ComponentRecord> components;                       ///< by id
  std::vector<LinkRecord> links;                                 ///< by id
  std::map<std::int64_t, std::vector<LinkPoint>> link_points;    ///< by link
  std::vector<TieRecord> ties;                                   ///< by strip
  std::optional<StorageRecord> storage;
  std::vector<HousekeepingReport> housekeeping;  ///< in the order of the flight
  std::optional<TimingRecord> timing;
  std::map<std::int64_t, OverlapRecord> overlaps;  ///< of frames; without the onboard database only of keyframes
  std::map<std::int64_t, FrameRecord> frames;      ///< only from the onboard database
  std::map<std::int64_t, CaptureRecord> captures;  ///< only from the onboard database
  std::vector<std::string> remarks;                ///< what is missing or contradicts itself
};

/// Assigns records and products to keyframes and strips; nothing is decoded. A product that contradicts its name or its
/// record gets a fault in `outbox`; the bytes of the other products move into the flight.
[[nodiscard]] Flight index_flight(Outbox& outbox);

/// The same as index_flight, with all keyframes decoded. A product that cannot be decoded gets a fault.
[[nodiscard]] Flight build_flight(Outbox& outbox);

/// The points of the structure that the keyframe has brought, where its strip stands now.
[[nodiscard]] std::vector<StructureTrackPoint> points_of(const Keyframe& keyframe);

// The track of the camera over a strip, and its unit.

/// Camera centres of the posed keyframes, in order, with their ids.
struct TrackPoint {
  std::int64_t keyframe_id = 0;
  Vec3 centre = Vec3::Zero();
};
[[nodiscard]] std::vector<TrackPoint> track_of(const Flight& flight, const Strip& strip);

/// "m" when an altimeter or the vehicle's navigation fixed the scale, else "units" (of which the first baseline is 1).
[[nodiscard]] const char* unit_of(const Flight& flight, const Strip& strip);

}  // namespace ilp::intake
