// All compile-time capacities of the flight software. Static memory follows from these numbers
// (`ilp-onboard --memory-map` prints it). Capacities that differ between machines are in the profile, a folder of
// cfg/profiles or any folder with a profile.hpp, which the CMake option ILP_PROFILE names.
#pragma once

#include <cstddef>
#include <cstdint>

#include "profile.hpp"

namespace ilp::limits {

inline constexpr std::size_t flight_stack_bytes = std::size_t{512} << 10U;  // 64 KiB used in the default flight
inline constexpr std::size_t worker_stack_bytes = std::size_t{128} << 10U;
// For requests of the C library before the heap is sealed; 72 KiB of them are the reserve of the C++ run-time.
// PostgreSQL's client libraries need more when they are loaded.
inline constexpr std::size_t early_heap_bytes = std::size_t{128} << 10U;
inline constexpr std::size_t postgres_early_heap_bytes = std::size_t{512} << 10U;

inline constexpr std::size_t max_image_pixels =
    static_cast<std::size_t>(max_image_width) * static_cast<std::size_t>(max_image_height);
// The most rows by which a point may move between its exposure and that of the middle row (rolling shutter).
inline constexpr std::int32_t max_rolling_rows = max_image_height / 20;
inline constexpr std::size_t spare_image_pixels =
    static_cast<std::size_t>(max_rolling_rows) * static_cast<std::size_t>(max_image_width);
inline constexpr std::int32_t max_image_side = max_image_width > max_image_height ? max_image_width : max_image_height;
inline constexpr std::int32_t min_image_side = 64;

// Pictures of a source may be larger than the flight's images and are then reduced row by row. The largest ones are
// those of common sensors with 12 megapixels (4056 x 3040, 4608 x 2592).
inline constexpr std::int32_t max_sensor_side = 4608;
// For one row of blocks of a JPEG picture, and tables: at most 236 KiB are used.
inline constexpr std::size_t jpeg_arena_bytes = std::size_t{256} << 10U;

// Camera with a V4L2 driver: buffers of the driver, frames that are held until the one nearest to the commanded time is
// known, reports, bytes of a row
inline constexpr std::size_t max_camera_buffers = 16;
inline constexpr std::size_t max_held_frames = 3;
inline constexpr std::size_t max_camera_updates = 16;
inline constexpr std::size_t max_camera_row_bytes = 2 * static_cast<std::size_t>(max_sensor_side) + 4096;

// The number of images that were read last and stay in memory, besides the newest one that was written.
inline constexpr std::size_t cached_images = 4;

// Image pyramid and overlap: the coarsest level has at most 32 px a side
inline constexpr int max_pyramid_levels = max_image_side > 1024 ? 7 : 6;

// Features and matches
inline constexpr std::size_t max_matches = max_corners;
inline constexpr int max_patch_side = 21;

// Two views
inline constexpr std::size_t max_ransac_trials = 2000;

// Multiview: one window of bundle adjustment
inline constexpr std::size_t max_bundle_cameras = max_window_keyframes + max_fixed_keyframes;
inline constexpr std::size_t max_bundle_observations = 6 * max_bundle_points;
inline constexpr std::size_t max_tracks = max_bundle_points;
inline constexpr std::size_t max_track_length = max_bundle_cameras;

// Self-calibration: keyframes of a set (masks of tracks have 8 bits), and points that are tracked through them
inline constexpr std::size_t max_calibration_views = 6;
inline constexpr std::size_t max_calibration_tracks = max_matches;
// Keyframes from whose planes and measurements the focal length is estimated
inline constexpr std::size_t max_plane_views = 64;

// Size of the final points of one batch: for every track 32 bytes and ten observations of 16 bytes
inline constexpr std::size_t max_structure_bytes = max_tracks * (32 + 10 * 16);

// Stereo: the rows of a rectified image are parallel to the baseline, which may have any angle in the original image.
// The largest width is therefore the diagonal of a 4:3 image, 5/4 of its longer side.
inline constexpr std::int32_t max_rectified_width = max_image_side + max_image_side / 4;
inline constexpr std::int32_t max_rectified_height = max_rectified_width;
inline constexpr std::size_t max_rectified_pixels =
    static_cast<std::size_t>(max_rectified_width) * static_cast<std::size_t>(max_rectified_height);

// Terrain
inline constexpr std::size_t richness_histogram_bins = 64;

// Places: ground that is recognised
inline constexpr std::size_t place_features = 256;          ///< of a keyframe whose pairs connect it well to its strip
inline constexpr std::size_t max_place_features = 1024;     ///< of a keyframe whose strip is weakly connected
inline constexpr std::size_t max_place_patches = 400;       ///< patches of a keyframe's image that are kept
inline constexpr std::size_t max_link_points = 128;         ///< points that both keyframes of a link see
inline constexpr std::size_t max_places = 4096;             ///< keyframes that can be found by their appearance
inline constexpr std::size_t indexed_place_features = 100;  ///< features of one keyframe in the index by descriptor
inline constexpr std::size_t place_vocabulary = 2048;       ///< descriptors that represent their neighbourhood
inline constexpr std::size_t place_vocabulary_places = 32;  ///< first keyframes, whose descriptors form the vocabulary
inline constexpr std::size_t place_candidates = 8;          ///< per keyframe, from position and as many from appearance
inline constexpr std::size_t max_place_candidates = 24;     ///< the same for a keyframe of a weakly connected strip
inline constexpr std::size_t max_near_places = 32;          ///< places whose ground is expected in a new keyframe
inline constexpr std::int64_t max_links_per_keyframe = 16;  ///< in a weakly connected strip; a factor of link_id()

// Products
inline constexpr int max_quality_layers = 8;
inline constexpr int max_wavelet_levels = 6;
/// Largest datagram of the vehicle's computer. Of a larger one the packets that end beyond this size are lost.
inline constexpr std::size_t max_vehicle_datagram_bytes = 2048;
/// Samples of the vehicle's navigation in memory: 400 s at 10 Hz.
inline constexpr std::size_t max_navigation_samples = 4096;
inline constexpr std::size_t max_product_bytes = max_image_pixels * 2 + 65536;
inline constexpr std::size_t max_metadata_bytes = 4096;

// Images at commanded places
inline constexpr std::size_t max_place_captures = 8;
inline constexpr std::size_t max_track_places = 8;  ///< latest positions of the vehicle that a forecast uses

// Downlink
inline constexpr std::size_t max_overdue_passes = 16;
inline constexpr std::size_t max_plan_candidates = 256;  ///< products that one plan compares
inline constexpr std::size_t max_exact_candidates =
    64;                                          ///< with at most this many, a plan also searches for the best fit
inline constexpr std::size_t plan_cells = 1024;  ///< steps into which this search divides the bytes of a pass
inline constexpr std::size_t max_refine_requests = 32;  ///< requests of the ground; the oldest are dropped

// Telecommands and telemetry
inline constexpr std::size_t max_report_bytes = 1400;     ///< largest telemetry packet: fits an Ethernet frame
inline constexpr std::size_t max_scheduled_bytes = 1024;  ///< largest telecommand that waits for its time
inline constexpr std::size_t max_list_items = 64;
inline constexpr std::size_t max_event_list = 128;
inline constexpr std::size_t max_scheduled = 128;     ///< requests of the time-based schedule
inline constexpr std::size_t max_open_requests = 64;  ///< telecommands that wait for their completion
inline constexpr std::size_t message_counters = 64;   ///< pairs of message type and destination that are counted
inline constexpr std::size_t telemetry_ring_bytes = std::size_t{128} << 10U;
// Packet link
inline constexpr std::size_t max_packet_bytes = 6 + 65536;  ///< the largest packet that a length field can state
inline constexpr std::size_t max_datagrams_per_pump = 64;   ///< per link and minor frame; more wait in the link
inline constexpr std::size_t max_security_associations = 4;
inline constexpr std::size_t max_stations = 8;  ///< destinations of a datagram link
inline constexpr std::size_t max_tcp_clients = 4;
inline constexpr std::size_t tcp_queue_bytes = std::size_t{128} << 10U;  ///< per client
inline constexpr std::size_t command_ring_bytes = std::size_t{128} << 10U;
inline constexpr std::size_t pdu_ring_bytes = std::size_t{256} << 10U;

// Files by CFDP
inline constexpr std::size_t max_transfers = 64;   ///< files on their way to the ground
inline constexpr std::size_t max_file_gaps = 256;  ///< requested gaps of one file
inline constexpr std::size_t max_pdu_bytes = 2048;
/// Largest file to the ground: a complete product, a refinement, or the points of a keyframe with their records.
inline constexpr std::size_t max_transfer_bytes =
    (max_product_bytes > max_structure_bytes ? max_product_bytes : max_structure_bytes) + 32768;
/// PostgreSQL's library holds several copies of a blob: in messages, in the result, and while its buffers grow.
inline constexpr std::size_t postgres_heap_bytes = 8 * max_transfer_bytes + (std::size_t{2} << 20U);
inline constexpr std::size_t max_closed_transfers = 64;  ///< kept to answer late PDUs
inline constexpr std::size_t max_uplinks = 2;            ///< concurrent uplinked files
inline constexpr std::size_t max_uplink_bytes = 65536;
inline constexpr std::size_t max_uplink_records = 8;  ///< the newest uplinked files stay on board

// Maps of orbiters (docs/map-relative.md)
inline constexpr std::size_t max_map_layers = 2;
inline constexpr std::size_t max_map_tiles = 4096;        ///< in all layers together
inline constexpr std::size_t max_map_tile_bytes = 65535;  ///< largest file of a tile, which fits an uplinked file
inline constexpr double map_share = 0.25;  ///< largest size of a map divided by the storage budget, which excludes maps
inline constexpr std::size_t max_map_features = 256;  ///< features of one tile for one illumination
inline constexpr std::size_t max_fix_points = 32;     ///< patches of a keyframe that its fix keeps

// Records and the store
inline constexpr std::size_t max_record_types = 48;
inline constexpr std::size_t max_record_bytes = 1024;
inline constexpr std::size_t max_record_fields = 48;
inline constexpr std::size_t max_blob_fields = 4;  ///< in one record
inline constexpr std::size_t max_path_bytes = 512;
inline constexpr std::size_t timing_bins = 20;       ///< bins of time histograms: powers of two of a microsecond
inline constexpr std::int64_t max_starts = 1'000;    ///< newest records that stay on board
inline constexpr std::int64_t max_events = 20'000;   ///< newest records that stay on board
inline constexpr std::int64_t max_commands = 1'000;  ///< newest records that stay on board

// Executive
inline constexpr std::size_t max_components = 20;
inline constexpr std::size_t max_schedule_slots = 64;

static_assert(max_image_width >= min_image_side && max_image_height >= min_image_side);
static_assert(max_matches <= 65535, "match indices are 16 bit");
static_assert(max_calibration_views <= 8, "masks have 8 bits");
static_assert(max_bundle_points <= 65535, "point indices are 16 bit");
static_assert(place_vocabulary % place_vocabulary_places == 0 &&
                  place_vocabulary / place_vocabulary_places <= indexed_place_features,
              "every one of the first places gives as many words");
static_assert(max_bundle_observations >= 2 * max_bundle_points, "every point needs two views");
static_assert(max_disparities < max_rectified_width);
static_assert(max_rectified_width <= 32767, "disparities in 1/16 px must fit 32 bit products");

}  // namespace ilp::limits
